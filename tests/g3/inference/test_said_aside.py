"""Mentions outside of clauses, the speaker, and ways of loads without a verb."""

import numpy as np
import pytest

from g3.actions.forklift_actions import WAIT
from g3.geometry.footprints import centre
from tests.g3.inference.following_commands import BOXES, TIRES, did, followed, told, under, world

ON_TRUCK = {"truck_1": ("truck", (18, 6)), "tires_1": (TIRES, (18, 6), 0, "truck-1")}
YARD = {
    "tires_1": (TIRES, (9, 5)),
    "crate_1": ("crate", (9, -4)),
    "boxes_1": (BOXES, (5, -9)),
    "truck_1": ("truck", (18, 6)),
    "barrel_1": ("barrel", (14, -12)),
}


def near(result, load, thing):
    state = followed(result).state
    apart = centre(state.thing(load).prism) - centre(state.thing(thing).prism)
    return float(np.linalg.norm(apart)) < 7


@pytest.mark.parametrize("load", ["tires", "crate", "boxes"])
@pytest.mark.parametrize("leads", ["The {} is not ours. ", "Somebody has sold this {}, so "])
def test_a_pronoun_stands_for_what_no_clause_names(leads, load, grounder):
    text = leads.format(load) + "put it on the truck"
    found = grounder.follow(text, world(**YARD), least=0.0, insist=True)
    assert under(found, f"{load}-1") == "truck-1"


def test_a_goal_alone_is_that_of_the_load_spoken_of(grounder):
    text = "The crate gets wet. Onto the truck, quick"
    found = grounder.follow(text, world(**YARD), least=0.0, insist=True)
    assert under(found, "crate-1") == "truck-1"


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        (
            "Bring the crate to me",
            "EVENT(r = Bring, l = OBJ(f = the crate), l2 = PATH(r = to, l = OBJ(f = me)))",
        ),
        ("Bring me the crate", "EVENT(r = Bring, l = OBJ(f = the crate), l2 = OBJ(f = me))"),
        (
            "Put the crate down at my feet",
            "EVENT(r = Put down, l = OBJ(f = the crate), l2 = PLACE(r = at, l = OBJ(f = my feet)))",
        ),
        (
            "Set the crate down where I am",
            "EVENT(r = Set down, l = OBJ(f = the crate), "
            "l2 = PLACE(r = where, l = EVENT(f = OBJ(f = I), r = am)))",
        ),
        (
            "Set the crate down where I'm standing",
            "EVENT(r = Set down, l = OBJ(f = the crate), "
            "l2 = PLACE(r = where, l = EVENT(f = OBJ(f = I), r = 'm standing)))",
        ),
    ],
)
@pytest.mark.parametrize("at", [(3, 14), (20, -8)])
def test_who_speaks_is_the_person_that_is_to_be_seen(text, tree, at, grounder):
    there = world(**YARD, person_1=("person", at))
    found = grounder.follow(told(text, tree), there, least=0.0)
    assert near(found, "crate-1", "person-1")


def test_crates_on_tires_off(grounder):
    text = "Tires off, crate on"
    there = world(**ON_TRUCK, crate_1=("crate", (9, -4)), truck_2=("truck", (18, -12)))
    found = grounder.follow(text, there, least=0.0)
    assert under(found, "tires-1") is None
    assert under(found, "crate-1") == "truck-1"


def test_several_loads_go_on_what_was_unloaded(grounder):
    text = "The tires come off the truck, then both crates go on it"
    tree = (
        "EVENT(f = OBJ(f = The tires), r = come, l = PATH(r = off, l = OBJ(f = the truck)));"
        "EVENT(f = OBJ(f = both crates), r = go, l = PLACE(r = on, l = OBJ(f = it)))"
    )
    there = world(**ON_TRUCK, crate_1=("crate", (9, -4)), crate_2=("crate", (6, 8)))
    found = grounder.follow(told(text, tree), there, least=0.0)
    assert [under(found, n) for n in ("tires-1", "crate-1", "crate-2")] == [
        None,
        "truck-1",
        "truck-1",
    ]


@pytest.mark.parametrize("when", ["before noon", "by Friday", "because the boss says so"])
def test_when_and_why_change_nothing(when, grounder):
    tree = "EVENT(r = Put, l = OBJ(f = the crate), l2 = [PLACE(r = on, l = OBJ(f = the truck)){}])"
    first, *rest = when.split(" ", 1)
    time = f", EVENT(r = {first}, l = OBJ(f = {rest[0]}))"
    there = world(**YARD)
    plain = grounder.follow(told("Put the crate on the truck", tree.format("")), there, least=0.0)
    text = f"Put the crate on the truck {when}"
    found = grounder.follow(told(text, tree.format(time)), there, least=0.0)
    assert did(found) == did(plain)
    assert under(found, "crate-1") == "truck-1"


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        ("Don't start yet", "EVENT(r = Don't start yet)"),
        ("Do nothing", "EVENT(r = Do, l = OBJ(f = nothing))"),
        ("No crate is to be moved", "EVENT(f = OBJ(f = No crate), r = is to be moved)"),
        ("Do not touch the crate", "EVENT(r = Do not touch, l = OBJ(f = the crate))"),
    ],
)
def test_who_only_forbids_is_waited_for(text, tree, grounder):
    found = grounder.follow(told(text, tree), world(**YARD), least=0.0)
    assert [action.kind for action in followed(found).actions] == [WAIT]
    assert found.question is None


def test_what_goes_elsewhere_is_not_ruled_out(grounder):
    text = "The crate doesn't go on the truck, it goes beside the barrel"
    tree = (
        "EVENT(f = OBJ(f = The crate), r = doesn't go, l = PLACE(r = on, l = OBJ(f = the truck)));"
        "EVENT(f = OBJ(f = it), r = goes, l = PLACE(r = beside, l = OBJ(f = the barrel)))"
    )
    found = grounder.follow(told(text, tree), world(**YARD), least=0.0)
    assert near(found, "crate-1", "barrel-1")


def test_who_turns_on_the_spot_goes_nowhere(grounder):
    found = grounder.follow("Turn around on the spot", world(**YARD), least=0.0)
    pose = followed(found).state.pose
    assert pose.tolist() == pytest.approx([0, 0, np.pi])


def test_left_from_is_a_side(grounder):
    tree = (
        "EVENT(r = Put, l = OBJ(f = the crate), l2 = PLACE(r = left {}, l = OBJ(f = the barrel)))"
    )
    of, apart = (
        grounder.follow(told(f"Put the crate left {word} the barrel", tree.format(word)), there)
        for word, there in (("of", world(**YARD)), ("from", world(**YARD)))
    )
    ends = [centre(followed(found).state.thing("crate-1").prism) for found in (of, apart)]
    assert ends[0].tolist() == pytest.approx(ends[1].tolist())


@pytest.mark.parametrize("into", ["in", "Inside", "into"])
@pytest.mark.parametrize("deck", ["truck", "lorry"])
def test_in_what_has_a_deck_is_on_it(into, deck, grounder):
    text = f"Put the crate {into} the {deck}"
    tree = f"EVENT(r = Put, l = OBJ(f = the crate), l2 = PATH(r = {into}, l = OBJ(f = the {deck})))"
    found = grounder.follow(told(text, tree), world(**YARD), least=0.0)
    assert under(found, "crate-1") == "truck-1"


def test_it_and_another_are_two(grounder):
    text = "Put it and the crate on the truck"
    things = "l = [OBJ(f = it), OBJ(f = the crate)]"
    tree = f"EVENT(r = Put, {things}, l2 = PLACE(r = on, l = OBJ(f = the truck)))"
    there = world("tires-1", **{**YARD, "tires_1": (TIRES, None)})
    found = grounder.follow(told(text, tree), there, least=0.0)
    assert [under(found, name) for name in ("tires-1", "crate-1")] == ["truck-1", "truck-1"]


@pytest.mark.parametrize(
    ("kind", "noun"), [("refrigerator-pallet", "refrigerator pallet"), (BOXES, "box pallet")]
)
def test_one_of_each_kind_is_meant_by_its_name(kind, noun, grounder):
    text = f"1 {noun} and 1 tire pallet on the truck"
    things = f"l = [OBJ(f = 1 {noun}), OBJ(f = 1 tire pallet)]"
    tree = f"EVENT({things}, l2 = PLACE(r = on, l = OBJ(f = the truck)))"
    there = world(
        a_1=(kind, (12, -9)),
        crate_1=("washing-machine-pallet", (6, -4)),
        tires_1=(TIRES, (9, 5)),
        truck_1=("truck", (18, 6)),
    )
    found = grounder.follow(told(text, tree), there, least=0.0)
    assert {a for _, a in did(found)} == {"a-1", "tires-1"}


@pytest.mark.parametrize("one", ["the left", "the leftmost"])
def test_the_next_of_a_list_has_the_noun_of_both(one, grounder):
    text = f"Put {one} and the right boxes on the truck"
    things = f"l = [OBJ(f = {one}), OBJ(f = the right boxes)]"
    tree = f"EVENT(r = Put, {things}, l2 = PLACE(r = on, l = OBJ(f = the truck)))"
    boxes = {f"boxes_{i}": (BOXES, (9, y)) for i, y in enumerate((6, 0, -6))}
    there = world(**boxes, crate_1=("crate", (5, 10)), truck_1=("truck", (20, 1)))
    found = grounder.follow(told(text, tree), there, least=0.0)
    assert {load for _, load in did(found)} == {"boxes-0", "boxes-2"}
