"""Which ends of a command that imitates people count as right."""

import json

import numpy as np
import pytest

from benchmarks.written_commands import (
    ENDS,
    FOLDER,
    Done,
    is_right,
    state_of,
)
from corpus_tools.following.plan_steps import carried_out
from eval.table_3.following import papers_own
from g3.actions.action_kinds import Action
from g3.actions.forklift_actions import CARRY, GO_STRAIGHT, PICK_UP, TURN, WAIT
from g3.actions.robot_state import is_load
from g3.groundings import Place
from g3.inference.grounder import Grounder
from g3.inference.problem.costs import RandomCost
from g3.sdc.sdc_notation import parse_brackets
from tests.worlds import prism

YARD = {
    "things": {
        "crate_1": ["crate", [6, 0]],
        "tires_1": ["tire-pallet", [12, 4]],
        "boxes_1": ["box-pallet", [12, -4]],
        "truck_1": ["truck", [20, 0], 0],
    },
    "held": None,
}
RECORDS = [
    json.loads(line)
    for path in sorted(FOLDER.glob("*.jsonl"))
    for line in path.read_text(encoding="utf-8").splitlines()
]


def carried_to(x, y, bottom=0.0):
    """What comes of carrying the crate somewhere."""
    start = state_of(YARD)
    place = Place(prism(x, y, (1, 1), (bottom, bottom + 0.9)))
    actions = [Action(CARRY, "crate-1", place=place)]
    return Done(actions, carried_out(start, actions))


@pytest.mark.parametrize(
    ("where", "right", "wrong"),
    [
        ((12, 7), "left-of crate-1 tires-1", "right-of crate-1 tires-1"),
        ((12, 1), "right-of crate-1 tires-1", "left-of crate-1 tires-1"),
        ((15, 5), "behind crate-1 tires-1", "front-of crate-1 tires-1"),
        ((9, 3), "front-of crate-1 tires-1", "behind crate-1 tires-1"),
        ((12, 0), "between crate-1 tires-1 boxes-1", "between crate-1 tires-1 truck-1"),
        ((12, 9), "by crate-1 tires-1", "by crate-1 boxes-1"),
        ((18, 0, 1.0), "on crate-1 truck-1", "ground crate-1"),
        ((25, 0), "ground crate-1 & moved crate-1", "on crate-1 truck-1"),
    ],
)
def test_a_load_ends_where_it_stands(where, right, wrong):
    done = carried_to(*where)
    assert is_right([wrong, right], done)
    assert not is_right([wrong], done)
    assert not is_right([f"{right} & pick crate-1"], done)
    assert not is_right(["near tires-1", "gone"], done)


def test_who_only_lifts_or_waits_puts_nothing_down():
    start = state_of(YARD)
    for action, ends in ((Action(PICK_UP, "crate-1"), {"pick", "moved"}), (Action(WAIT), {"gone"})):
        done = Done([action], carried_out(start, [action]))
        named = {"on": "crate-1 truck-1", "by": "crate-1 tires-1", "gone": ""}
        tried = {"pick", "moved", "ground", "on", "by", "gone"}
        assert {e for e in tried if is_right([f"{e} {named.get(e, 'crate-1')}"], done)} == ends


@pytest.mark.parametrize(
    ("kind", "amount", "right", "wrong"),
    [
        (GO_STRAIGHT, 10.0, "at 10 0 & heading 0", "at 8 0"),
        (GO_STRAIGHT, 9.0, "at 10 0", "at 10 2"),
        (TURN, np.pi, "at 0 0 & heading 180", "heading 150"),
        (TURN, -np.pi / 2, "heading -90", "heading 90"),
    ],
)
def test_a_robot_ends_where_it_went(kind, amount, right, wrong):
    for held, crate in ((None, ["crate", [6, 9]]), ("crate-1", ["crate"])):
        start = state_of({"things": {**YARD["things"], "crate_1": crate}, "held": held})
        action = Action(kind, amount=amount)
        done = Done([action], carried_out(start, [action]))
        assert is_right([right], done)
        assert not is_right([wrong], done)
        assert is_right(["still crate-1"], done) is (held is not None)


def test_every_command_has_a_yard_and_ends_in_it():
    assert RECORDS
    yards = {}
    for record in RECORDS:
        yard = json.dumps([record["things"], record["held"]])
        state = yards[yard] = yards.get(yard) or state_of(record)
        assert state.held == record["held"]
        names = {o.id for o in state.context.objects}
        for end in record["want"]:
            for name, *things in (part.split() for part in end.split("&")):
                assert name in ENDS
                if name in ("at", "heading"):
                    assert np.isfinite(list(map(float, things))).all()
                    continue
                assert set(things) <= names
                # "still" and "near" leave things where they are
                assert name in ("still", "near", "gone") or is_load(state, things[0]), record


def test_the_papers_own_model_leaves_clauses_as_they_are():
    start = state_of(YARD)
    clauses = parse_brackets("EVENT(r = Make, l = OBJ(f = a left turn))")
    for grounder, relation in (
        (papers_own(RandomCost()), ["Make"]),
        (Grounder(RandomCost()), ["turn", "left"]),
    ):
        (sdc,) = grounder.follow(clauses, start, least=0.0, insist=True).sdcs
        assert [word.text for word in sdc.relation] == relation
