"""Sentences that ask for nothing."""

import numpy as np
import pytest

from g3.actions.robot_state import start_state
from g3.inference.problem.statements import without_statements
from g3.inference.problem.world_nouns import Nouns
from g3.sdc.clauses import all_words
from g3.sdc.sdc_notation import parse_brackets
from tests.g3.inference.following_commands import did, under, world

LIFT = "EVENT(r = Lift, l = OBJ(f = it))"
GO = "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the gate)))"
CRATE, GATE = "OBJ(f = the crate)", "OBJ(f = the gate)"
CRATES = f"OBJ(f = OBJ(f = two crates), r = by, l = {GATE})"


def nouns():
    yard = world(crate_1=("crate", (9, 4)), fridge_1=("refrigerator-pallet", (9, -4)))
    return Nouns(start_state(yard))


@pytest.mark.parametrize(
    ("said", "named"),
    [
        # What there is, is named; nothing is done about it.
        (f"EVENT(r = There are, l = {CRATES})", ["two crates by the gate"]),
        (f"EVENT(f = OBJ(f = you), r = see, l = {CRATE})", ["the crate"]),
        (f"EVENT(f = {CRATE}, r = is)", ["the crate"]),
        (f"EVENT(f = {CRATE}, r = were loaded, l = PLACE(r = on, l = {GATE}))", ["the crate"]),
        ("EVENT(f = OBJ(f = she), r = has, l = OBJ(f = a question))", ["she", "a question"]),
        ("EVENT(f = OBJ(f = he), r = wants, l = OBJ(f = a look))", ["he", "a look"]),
        ("EVENT(f = OBJ(f = they), r = cost, l = EVENT(r = do))", ["they"]),
        ("EVENT(f = OBJ(f = you), r = what are waiting, l = PLACE(r = for))", []),
        # Who is called, and politeness.
        ("EVENT(r = forklift)", []),
        ("EVENT(r = alright hand)", []),
        ("EVENT(r = thank, l = OBJ(f = you))", []),
        # That this is all.
        ("EVENT(r = that 's, l = OBJ(f = it))", []),
        ("PLACE(r = that s, l = OBJ(f = all))", []),
        # What is on the forks meanwhile.
        (f"EVENT(r = while still carrying, l = {CRATE})", ["the crate"]),
        # A load that was taken for a verb.
        ("EVENT(r = fridge)", ["fridge"]),
    ],
)
def test_a_statement_names_things_and_asks_for_nothing(said, named):
    *stated, last = without_statements(parse_brackets(f"{said}\n{GO}"), nouns())
    assert last == parse_brackets(f"{said}\n{GO}")[-1]
    assert {sdc.type for sdc in stated} <= {"OBJECT"}
    assert [" ".join(word.text for word in all_words(sdc)) for sdc in stated] == named


@pytest.mark.parametrize(
    "said",
    [
        f"EVENT(f = {CRATE}, r = must be, l = PLACE(r = on, l = {GATE}))",
        f"EVENT(r = shove, l = {CRATE})",
        f"EVENT(f = OBJ(f = she), r = wants, l = {CRATE})",
        f"EVENT(f = OBJ(f = you), r = why do n't drive, l = PATH(r = to, l = {CRATE}))",
        f"EVENT(f = OBJ(f = I), r = what need is, l = {CRATE})",
        f"EVENT(f = OBJ(f = it), r = goes, l = PATH(r = on, l = {GATE}))",
        f"EVENT(f = OBJ(f = I), r = see to it, l = EVENT(r = that lift, l = {CRATE}))",
        "EVENT(r = stop)",
        CRATE,
    ],
)
def test_what_asks_for_something_or_only_names_it_is_kept(said):
    given = parse_brackets(f"{said}\n{GO}")
    assert without_statements(given, nouns()) == tuple(given)


def test_a_wish_is_what_the_next_clause_handles():
    wish = f"EVENT(f = OBJ(f = I), r = want, l = {CRATES})"
    first, _ = without_statements(parse_brackets(f"{wish}\n{LIFT}"), nouns())
    assert first.type == "OBJECT"
    for alone in (wish, f"{wish}\n{GO}"):
        assert without_statements(parse_brackets(alone), nouns())[0].type == "EVENT"


def test_a_command_of_statements_alone_is_kept():
    given = parse_brackets(f"EVENT(r = There are, l = {CRATES})\nEVENT(r = forklift)")
    assert without_statements(given, nouns()) == tuple(given)
    assert without_statements((), nouns()) == ()


@pytest.mark.parametrize(
    "text",
    [
        "There are two crates. Pick up the left one.",
        "Forklift, pick up the left crate.",
        "Operator, pick up the left crate.",
        "There are two crates on the cone. Pick up the left one.",
        "See the cone over there? Never mind. Pick up the left crate, thank you.",
        "Pick up the left crate pls, the boss has no time.",
    ],
)
def test_nothing_is_done_about_a_statement(text, widely_trained):
    yard = world(crate_1=("crate", (9, 4)), crate_2=("crate", (9, -4)), cone_1=("cone", (15, 0)))
    assert did(widely_trained.follow(text, yard, least=0.0)) == [("pick up", "crate-1")]


def test_a_thing_that_is_named_first_is_spoken_of(widely_trained):
    yard = world(crate_1=("crate", (9, 6)), truck_1=("truck", (15, -6)))
    found = widely_trained.follow("Truck, drive to it", yard, least=0.0)
    assert np.linalg.norm(found.plan.state.pose[:2] - (15, -6)) < np.hypot(15, 6) / 2


def test_the_load_that_the_robot_is_holding(widely_trained):
    yard = world(
        "crate-1",
        crate_1=("crate",),
        crate_2=("crate", (9, 5)),
        trailer_1=("trailer", (13, -6)),
    )
    for text in (
        "Set the crate you're holding on the trailer",
        "put the crate that you have down on the trailer",
    ):
        assert under(widely_trained.follow(text, yard, least=0.0), "crate-1") == "trailer-1"
