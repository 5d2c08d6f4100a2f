"""Phrases inside clauses that say otherwise what a plain phrase says."""

import numpy as np
import pytest

from g3.inference.problem.plain_phrases import plain_phrases
from g3.sdc.sdc_notation import format_brackets, parse_brackets
from tests.g3.inference.following_commands import did, end_of, under, world

DRUM, GATE = "OBJ(f = the drum)", "OBJ(f = the gate)"
THERE = f"PLACE(r = next to, l = {GATE})"
ONE_BY = f"OBJ(f = OBJ(f = the one), r = by, l = {GATE})"
BY = f"OBJ(f = {DRUM}, r = by, l = {GATE})"
BETWEEN = f"PLACE(r = between, l = {DRUM}, l2 = {GATE})"
MIDDLE = f"OBJ(f = OBJ(f = the middle), r = between, l = {DRUM}, l2 = {GATE})"
FLOOR = "PLACE(r = on, l = OBJ(f = the ground))"


def put(*places):
    return f"EVENT(r = Put, l = {DRUM}, l2 = [{', '.join(places)}])"


def of(figure, relation, landmark):
    return f"OBJ(f = {figure}, r = {relation}, l = {landmark})"


@pytest.mark.parametrize(
    ("said", "plainly"),
    [
        (of(DRUM, "that is standing by", GATE), of(DRUM, "by", GATE)),
        (of(DRUM, "which 's on", GATE), of(DRUM, "on", GATE)),
        (of(DRUM, "that leads to", GATE), None),
        (of(DRUM, "by", GATE), None),
        (put(FLOOR, THERE), put(THERE)),
        (put(f"PLACE(r = on, l = {of('OBJ(f = the floor)', 'next to', GATE)})"), put(THERE)),
        # On the ground alone, or on top of something, is what it says.
        (put(FLOOR), None),
        (put(FLOOR, f"PLACE(r = on, l = {GATE})"), None),
        # "On it" is a part of what is said of the truck.
        (
            put(
                f"PLACE(r = on, l = {of(GATE, 'that has', DRUM)})", "PLACE(r = on, l = OBJ(f = it))"
            ),
            put(f"PLACE(r = on, l = {of(GATE, 'that has', DRUM)})"),
        ),
        # What is picked up somewhere stands there; what is taken there or put there doesn't.
        (
            f"EVENT(r = Pick up, l = {DRUM}, l2 = PLACE(r = on, l = {GATE}))",
            f"EVENT(r = Pick up, l = {of(DRUM, 'on', GATE)})",
        ),
        (
            f"EVENT(r = Pick up, l = {DRUM}, l2 = {THERE})",
            f"EVENT(r = Pick up, l = {of(DRUM, 'next to', GATE)})",
        ),
        (f"EVENT(r = Get, l = {DRUM}, l2 = {THERE})", None),
        (f"EVENT(r = Pick up, l = {DRUM}, l2 = PLACE(f = there))", None),
        (f"EVENT(r = Lift, l = {DRUM}, l2 = PLACE(r = onto, l = {GATE}))", None),
        (f"EVENT(r = Put, l = {DRUM}, l2 = PLACE(r = on, l = {GATE}))", None),
        # "The one" says more of what was just named, if nothing but a comma is between.
        (
            f"EVENT(r = Lift, l = [{DRUM}, {ONE_BY}])",
            f"EVENT(r = Lift, l = {of(DRUM, 'by', GATE)})",
        ),
        (f"EVENT(r = Lift, l = [{DRUM}, {of(DRUM, 'by', GATE)}])", None),
        # "No drums" is no drums, not some.
        (
            of(GATE, "with", "OBJ(f = no drums)"),
            of(GATE, "with no", "OBJ(f = drums)"),
        ),
        # Nothing is told of "it" itself.
        (
            f"EVENT(r = Get up, l = {of('OBJ(f = it)', 'on', GATE)})",
            f"EVENT(r = Get up, l = OBJ(f = it), l2 = PLACE(r = on, l = {GATE}))",
        ),
        # What is counted from a side, and a landmark that is on a side.
        (
            "EVENT(r = Lift, l = OBJ(f = the second drum), l2 = PATH(r = from the left))",
            "EVENT(r = Lift, l = OBJ(f = OBJ(f = the second drum), r = from the left))",
        ),
        (f"EVENT(r = Lift, l = {DRUM}, l2 = PATH(r = from the left))", None),
        (
            put(f"PLACE(r = by, l = {GATE})", "PLACE(r = on the left)"),
            put(f"PLACE(r = by, l = {of(GATE, 'on the left', '')})").replace(", l = )", ")"),
        ),
        (put("PLACE(r = by, l = OBJ(f = it))", "PLACE(r = on the left)"), None),
        # What is somewhere, not what is put there.
        (
            f"EVENT(r = Put, l = OBJ(f = whichever drum), l2 = [PLACE(r = is near, l = {GATE}), "
            f"PLACE(r = on, l = {DRUM})])",
            f"EVENT(r = Put, l = {of('OBJ(f = whichever drum)', 'near', GATE)}, "
            f"l2 = PLACE(r = on, l = {DRUM}))",
        ),
        (f"EVENT(r = Put, l = {DRUM}, l2 = PLACE(r = is for, l = {GATE}))", None),
        # The ground, and a side or the middle, are where the thing beside them says.
        (
            put(f"PLACE(r = on, l = {of('OBJ(f = the near side)', 'in front of', GATE)})"),
            put(f"PLACE(r = in front of, l = {GATE})"),
        ),
        (put(f"PLACE(r = on, l = {of('OBJ(f = the ground)', 'in', MIDDLE)})"), put(BETWEEN)),
        (put("PATH(r = to, l = OBJ(f = the ground))", THERE), put(THERE)),
        (
            put(FLOOR, f"PLACE(r = on the left of, l = {GATE})"),
            put(f"PLACE(r = on the left of, l = {GATE})"),
        ),
        (
            put(f"PLACE(r = on, l = {of('OBJ(f = the ground)', 'on the left of', GATE)})"),
            put(f"PLACE(r = on the left of, l = {GATE})"),
        ),
        # A relation said the other way round.
        (
            f"OBJ(f = {DRUM}, r = that the man is standing beside)",
            of(DRUM, "beside", "OBJ(f = the man)"),
        ),
        (f"OBJ(f = {DRUM}, r = that the man is pushing)", None),
        (
            of(DRUM, "having", of("OBJ(f = a cone)", "next to", "OBJ(f = it)")),
            of(DRUM, "next to", "OBJ(f = a cone)"),
        ),
        (of(DRUM, "with", of("OBJ(f = a cone)", "on", "OBJ(f = it)")), None),
        # The back is where it is, not what it is by.
        (
            of(DRUM, "all the way in", "OBJ(f = the back)"),
            f"OBJ(f = {DRUM}, r = all the way in the back)",
        ),
        (of(DRUM, "in", "OBJ(f = the back yard)"), None),
        (
            f"EVENT(r = Pick, l = {DRUM}, l2 = PLACE(r = at, l = OBJ(f = the back)))",
            f"EVENT(r = Pick, l = OBJ(f = {DRUM}, r = at the back))",
        ),
        # A side before a noun is the thing's.
        ("EVENT(r = Grab left, l = OBJ(f = drum))", "EVENT(r = Grab, l = OBJ(f = left drum))"),
        ("EVENT(r = Grab left, l = OBJ(f = the drum))", None),
        ("EVENT(r = Turn left, l = OBJ(f = drum))", None),
    ],
)
def test_phrases_are_said_plainly(said, plainly):
    (sdc,) = parse_brackets(said)
    (expected,) = parse_brackets(plainly or said)
    found = plain_phrases(sdc)
    assert format_brackets([found]) == format_brackets([expected])
    assert plain_phrases(found) == found


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("how", ["on the ground by the truck", "on the floor next to the truck"])
def test_on_the_ground_by_the_truck_is_by_the_truck(how, side, widely_trained):
    yard = world(
        tires_1=("tire-pallet", (9, -7 * side)),
        truck_1=("truck", (8, 9 * side)),
        cone_1=("cone", (12, -10 * side)),
    )
    found = widely_trained.follow(f"Pick up the tires and put them {how}", yard, least=0.0)
    assert did(found)[-1][1] == "tires-1"
    assert under(found, "tires-1") is None
    assert np.linalg.norm(end_of(found, "tires-1") - (8, 9 * side)) < 5


def test_nothing_stands_on_the_truck_that_has_nothing_on_it(widely_trained):
    yard = world(
        "tires-1",
        tires_1=("tire-pallet",),
        truck_1=("truck", (10, 9)),
        truck_2=("truck", (10, -9)),
        crate_1=("crate", (8.5, -9), 0, "truck-2"),
    )
    text = "Put the tires on the truck that doesn't have anything on it"
    assert under(widely_trained.follow(text, yard), "tires-1") == "truck-1"


def test_the_ground_and_the_side_of_a_thing_may_be_one_place_in_a_tree():
    text = "on ground, left of the gate"
    notation = f"PLACE(r = on left of, l = [OBJ(f = ground), {GATE}])"
    (place,) = parse_brackets(notation, command=text)
    assert format_brackets((plain_phrases(place),)) == format_brackets(
        parse_brackets(f"PLACE(r = left of, l = {GATE})", command=text)
    )


@pytest.mark.parametrize("side", ["your left shoulder", "the right hand", "left hand"])
def test_a_side_of_who_looks_there_is_no_landmark(side):
    (drum,) = parse_brackets(of(DRUM, "over", f"OBJ(f = {side})"))
    found = plain_phrases(drum)
    assert not found.landmark1
    assert [word.text for word in found.relation] == ["over", *side.split()]
