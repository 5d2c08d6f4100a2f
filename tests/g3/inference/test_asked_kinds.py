"""Kinds of actions that words ask for."""

import pytest

from g3.actions.action_kinds import KINDS, Action
from g3.actions.forklift_actions import DRIVE_AWAY, DRIVE_PAST, DRIVE_TO, LINE_UP, WAIT
from g3.inference.potentials.cases import PathCase
from g3.inference.problem.asked_kinds import asked_kinds, asks_to_wait
from g3.inference.problem.grounding_problem import Arguments, Candidate
from tests.g3.inference.ruled import EMPTY, WEIGHT, adds, of_actions, tree_of
from tests.worlds import thing

TRUCK, TIRES = thing("truck", "truck", 8, 0), thing("tires", "tires", 0, 8)


def asked(notation, root=0):
    tree = tree_of(notation)
    return {kind.name for kind in asked_kinds(tree, root)}


@pytest.mark.parametrize(
    ("notation", "kinds"),
    [
        ("EVENT(r = Drive, l = PATH(r = away from, l = OBJ(f = the desk)))", "drive away"),
        ("EVENT(r = Move away, l = PATH(r = from, l = OBJ(f = the desk)))", "drive away"),
        ("EVENT(r = Back, l = PATH(r = away from, l = OBJ(f = it)))", "back up"),
        ("EVENT(r = Turn, l = PATH(r = away from, l = OBJ(f = the desk)))", "turn away"),
        ("PATH(r = away from, l = OBJ(f = the desk))", "drive away"),
        (
            "EVENT(r = reverse, l = OBJ(f = the forklift), l2 = PATH(r = away from, "
            "l = OBJ(f = it)))",
            "back up",
        ),
        ("EVENT(r = Go, l = PATH(r = past, l = OBJ(f = the cone)))", "drive past"),
        (
            "EVENT(r = Go, l = [PATH(r = forward), PATH(r = past, l = OBJ(f = the cone))])",
            "drive past",
        ),
        ("EVENT(r = Pass, l = OBJ(f = the cone))", "drive past"),
        (
            "EVENT(r = Take, l = OBJ(f = it), l2 = PATH(r = past, l = OBJ(f = the cone)))",
            "",
        ),
        (
            "EVENT(r = Move, l = OBJ(f = it), l2 = PATH(r = past, l = OBJ(f = the cone)))",
            "carry, drive past, pick up, put down",
        ),
        (
            "EVENT(r = Back, l = OBJ(r = away from, f = OBJ(f = the forklift), l = OBJ(f = it)))",
            "back up",
        ),
        ("PATH(r = past, l = OBJ(f = the copier))", "drive past"),
        ("EVENT(r = Face, l = OBJ(f = the shelf))", "face"),
        ("EVENT(r = Turn, l = PATH(r = towards, l = OBJ(f = the shelf)))", "face"),
        ("EVENT(r = turn to face, l = OBJ(f = the shelf))", "face"),
        (
            "EVENT(r = Line up, l = OBJ(f = the forklift), l2 = PATH(r = with, "
            "l = OBJ(f = the crate)))",
            "line up",
        ),
        (
            "EVENT(r = align, l = OBJ(f = the forks), l2 = PATH(r = with, l = OBJ(f = it)))",
            "line up",
        ),
        ("EVENT(r = Park, l = PLACE(r = by, l = OBJ(f = the shelf)))", "park"),
        ("EVENT(r = Raise, l = OBJ(f = your forks))", "raise forks"),
        ("EVENT(r = Lift, l = OBJ(f = the forklift))", "raise forks"),
        ("EVENT(r = lower, l = OBJ(f = the prongs))", "lower forks, put down"),
        ("EVENT(r = Wait)", "wait"),
        ("EVENT(r = stop, l = OBJ(f = a moment))", "wait"),
        # Words that say something else, or leave it open.
        ("EVENT(r = Don't turn, l = PATH(r = towards, l = OBJ(f = the shelf)))", ""),
        ("EVENT(r = Turn, l = PATH(r = to, l = OBJ(f = your left)))", ""),
        ("EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the shelf)))", ""),
        (
            "EVENT(r = Go, l = [PATH(r = past, l = OBJ(f = the cone)), PATH(r = to, "
            "l = OBJ(f = the shelf))])",
            "",
        ),
        (
            "EVENT(r = Drive, l = [PATH(r = away from, l = OBJ(f = the cone)), PATH(r = to, "
            "l = OBJ(f = the shelf))])",
            "",
        ),
        (
            "EVENT(r = Move, l = OBJ(f = the crate), l2 = PATH(r = away from, "
            "l = OBJ(f = the cone)))",
            "",
        ),
        ("EVENT(r = stop, l = OBJ(f = two feet), l2 = PATH(r = away from, l = OBJ(f = it)))", ""),
        ("EVENT(r = Lift, l = OBJ(f = the crate))", ""),
        ("EVENT(r = Raise and lower, l = OBJ(f = your forks))", ""),
        ("EVENT(r = park, l = OBJ(f = it), l2 = PLACE(r = by, l = OBJ(f = the shelf)))", ""),
        ("EVENT(r = wait, l = PLACE(r = at, l = OBJ(f = the shelf)))", ""),
        ("EVENT(r = Keep going, l = PATH(r = straight))", ""),
        ("EVENT(r = Line, l = OBJ(f = the crates))", ""),
    ],
)
def test_words_ask_for_kinds(notation, kinds):
    assert ", ".join(sorted(asked(notation))) == kinds


def test_a_command_may_ask_for_waiting_alone():
    assert asks_to_wait(tree_of("EVENT(r = Wait)"))
    assert not asks_to_wait(tree_of("EVENT(r = Stop); EVENT(r = go)"))


def test_another_kind_than_words_ask_for_costs():
    actions = [Action(DRIVE_TO, target=(TRUCK,)), Action(DRIVE_PAST, target=(TRUCK,)), Action(WAIT)]
    found = Arguments((None,), (None,), -1, {}, asked=frozenset({DRIVE_PAST}))
    costs = of_actions("asked-kind", "EVENT(r = Go)", actions, found)
    assert costs.tolist() == [WEIGHT["asked-kind"], 0.0, WEIGHT["asked-kind"]]
    assert not of_actions("asked-kind", "EVENT(r = Go)", actions).any()


def test_what_the_robot_leaves_is_what_the_words_name():
    tree = tree_of("PATH(r = away from, l = OBJ(f = the truck))")
    actions = [
        Action(DRIVE_AWAY, target=(TRUCK,)),
        Action(LINE_UP, target=(TIRES,)),
        Action(DRIVE_TO, target=(TIRES,)),
    ]
    marks = [Candidate((TRUCK,), 0.0, {}), Candidate((TIRES,), 0.0, {})]
    case = PathCase(tree, 0, EMPTY.state, actions, marks, EMPTY)
    other = adds("own-landmark", case) < 0
    assert other.tolist() == [[False, True], [True, False], [False, False]]


def test_kinds_that_nobody_asks_for_are_not_tried():
    on_request = {name for name, kind in KINDS.items() if kind.on_request}
    assert {"face", "drive away", "raise forks"} <= on_request
    assert not {"wait", "drive to", "drive past", "pick up", "put down"} & on_request
