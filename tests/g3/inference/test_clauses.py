"""What an EVENT's words say by their class."""

from dataclasses import replace

import numpy as np
import pytest

from g3.actions.action_kinds import Action, kind_named
from g3.actions.forklift_actions import DRIVE_PAST, DRIVE_TO
from g3.groundings import Context
from g3.inference.potentials.cases import ActionCase
from g3.inference.potentials.potential_registry import added_by
from g3.inference.problem.grounding_problem import Arguments, Candidate
from tests.g3.features.scenes import robot, thing
from tests.g3.inference.ruled import WEIGHT, of_actions, problem_in, tree_of

KINDS = ("wait", "drive to", "pick up", "carry", "put down")
UNUSUAL = WEIGHT["verb-take"]
TIRES = thing("tires", "pallet", 8, 0)
PROBLEM = problem_in(Context("scene", (TIRES, robot()), (), "robot"))
IT = Candidate((TIRES,), 0.0, {})


def costs(clauses, *, theme=True, leads=False, held=None, at_start=None, at_place=True):
    """What verbs add, by kinds of actions.

    Parameters
    ----------
    theme, leads, at_place
        Whether the clause names what is handled, and where to, and whether that is a PLACE.
    held, at_start
        What is on the forks, and what was when the command was given.
    """
    tree = tree_of(clauses)
    goal_path = -1 if at_place else tree.below(0, ("l2",), "PATH")[0]
    found = Arguments((IT if theme else None,), (IT if leads else None,), goal_path, {})
    problem = replace(PROBLEM, state=replace(PROBLEM.state, held=at_start))
    state = replace(PROBLEM.state, held=held)
    case = ActionCase(tree, 0, state, found, [Action(kind_named(name)) for name in KINDS], problem)
    verbs = [scores for name, scores in added_by(case).items() if name.startswith("verb-")]
    return dict(zip(KINDS, sum(verbs, np.zeros(len(KINDS))).tolist(), strict=True))


def dear(clauses, **options):
    return {kind for kind, cost in costs(clauses, **options).items() if cost}


def it(verb):
    return f"EVENT(r = {verb}, l = OBJ(f = it))"


@pytest.mark.parametrize(
    ("verb", "unusual"),
    [
        ("turn", {"pick up", "carry", "put down"}),
        ("wait", {"pick up", "carry", "put down"}),
        ("Set down", {"wait", "drive to", "pick up"}),
        ("Lift", {"carry", "put down"}),
        # Who leaves something goes away or puts it down.
        ("leave", {"pick up"}),
        # Who moves a load may drive it somewhere, pick it up or put it down.
        ("Move", set()),
        # What is no verb of doing handles nothing.
        ("avoid", {"pick up", "carry", "put down"}),
    ],
)
def test_a_verb_is_of_a_sort_of_action(verb, unusual):
    # Where something is held, "leave it" doesn't mean to leave it alone.
    held = "tires" if verb == "leave" else None
    found = costs(it(verb), theme=False, held=held, at_start=held)
    assert {kind for kind, cost in found.items() if cost} == unusual
    assert set(found.values()) <= {0.0, UNUSUAL, 2 * UNUSUAL}


def test_who_moves_a_load_somewhere_puts_it_down_or_drives_there_with_it():
    held = {"held": "tires", "at_start": "tires"}
    along = "EVENT(r = Move, l = OBJ(f = it), l2 = PATH(r = along, l = OBJ(f = the wall)))"
    assert dear(along, leads=True, at_place=False) == {"wait", "drive to", "pick up"}
    assert dear(along, leads=True, at_place=False, **held) == {"wait", "pick up"}
    assert dear(it("Move"), leads=True, **held) == {"wait", "drive to", "pick up"}


def test_who_takes_something_picks_it_up_unless_the_forks_have_it():
    assert dear(it("Take")) == {"wait", "drive to", "carry", "put down"}
    assert dear(it("Take"), leads=True) == {"wait", "drive to", "put down"}
    assert dear(it("Take"), held="tires", at_start="tires") == {"carry", "put down"}


def test_what_the_command_has_had_picked_up_is_put_down_at_the_end():
    taken = {"leads": True, "held": "tires"}
    for verb in ("Move", "Take"):
        assert dear(it(verb), **taken) == {"wait", "drive to", "pick up"}
    assert dear(it("Go"), **taken) == {"pick up", "carry", "put down"}


def test_unloading_takes_a_load_off_something_or_off_the_forks():
    off_something = dear(it("Unload"))
    assert "put down" in off_something
    assert "pick up" not in off_something
    assert dear(it("Unload"), held="tires") == {"wait", "drive to", "pick up"}


def test_who_holds_a_load_keeps_it_and_takes_it_only_from_elsewhere():
    assert dear(it("hold"), held="tires") == {"pick up", "carry", "put down"}
    assert dear("EVENT(r = hold)", theme=False) == {"pick up", "carry", "put down"}
    assert dear(it("hold")) == {"wait", "drive to", "carry", "put down"}


def test_forks_that_are_lowered_put_down_what_is_on_them():
    lower, lift = (f"EVENT(r = {verb}, l = OBJ(f = the forks))" for verb in ("Lower", "Lift"))
    assert dear(lower, held="tires") == {"wait", "drive to", "pick up", "carry"}
    assert dear(lower) == {"pick up", "carry", "put down"}
    assert dear(lift) == {"pick up", "carry", "put down"}


def test_what_is_to_be_left_alone_is_not_handled():
    assert dear(it("leave")) == {"pick up", "carry", "put down"}


def test_a_thing_that_is_to_be_somewhere_is_carried_there():
    boxes = "EVENT(f = OBJ(f = the boxes), r = should be, l = PLACE(r = on, l = OBJ(f = it)))"
    assert dear(boxes, leads=True) == {"wait", "drive to", "pick up"}


def test_who_goes_to_something_goes_there():
    go = (
        "EVENT(r = Go, l2 = [PATH(r = past, l = OBJ(f = the barrel)), "
        "PATH(r = to, l = OBJ(f = the truck))])"
    )
    actions = [Action(DRIVE_TO, goal=0), Action(DRIVE_PAST)]
    past, to = tree_of(go).below(0, ("l2",), "PATH")
    leads = {path: Arguments((None,), (IT,), path, {}) for path in (past, to, -1)}
    cost = {p: of_actions("reaches-goal", go, actions, found) for p, found in leads.items()}
    assert cost[to].tolist() == [0, WEIGHT["reaches-goal"]]
    assert not cost[past].any()
    assert not cost[-1].any()
