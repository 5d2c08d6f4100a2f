"""What logs show: the load, what is moved, what is done to it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from g3.actions.action_kinds import Focus, kind_that, possible_actions
from g3.actions.forklift_actions import CARRY, PICK_UP, PUT_DOWN, WAIT
from g3.actions.logged_actions import NOTHING, Handling, handling, loaded, moved, recorded
from g3.actions.robot_state import start_state
from g3.groundings import FloatArray, Trajectory
from tests.g3.actions.yards import box, logged, with_load, yard


def test_the_load_is_found() -> None:
    assert loaded(yard()) is None
    assert loaded(with_load((1.0, -2.0, 2.0))) == "load"
    standing = yard((0.0, 0.0, 0.0), box("near", "tire pallet", (1.1, 0.0, 0.0)))
    assert loaded(standing) is None


def test_what_moves_off_with_the_agent_is_its_load() -> None:
    context = yard((0.0, 0.0, 0.0), box("near", "tire pallet", (1.1, 0.0, 0.0)))
    t, x = np.array([100.0, 101.0, 102.0]), np.array([0.0, -0.4, -1.0])

    def along(start: FloatArray) -> Trajectory:
        return Trajectory(t, start + np.column_stack((x, 0 * x, 0 * x)), 0 * x)

    moving = tuple(
        replace(o, trajectory=along(o.trajectory.xyz[0])) if o.id in ("near", "agent") else o
        for o in context.objects
    )
    assert loaded(replace(context, objects=moving)) == "near"


@pytest.mark.parametrize("context", [yard(), with_load()], ids=["empty", "loaded"])
def test_a_log_shows_what_its_action_does_to_a_load(context) -> None:
    state = start_state(context)
    goals = tuple((place,) for place in context.places)
    actions = possible_actions(state, Focus(("tires", "boxes"), goals))
    assert {a.kind.handling for a in actions} == (
        {NOTHING, PUT_DOWN.handling} if state.held else {NOTHING, PICK_UP.handling, CARRY.handling}
    )
    for action in actions:
        log = logged(context, action)
        assert handling(log) == action.kind.handling
        still = action.kind is WAIT or not (action.kind.handles or state.held)
        turned = action.kind.unit == "rad"
        assert turned or bool(moved(recorded(log))) != still


def test_what_is_done_to_a_load_tells_the_kind() -> None:
    assert kind_that(Handling(takes=True)) is PICK_UP
    assert kind_that(Handling(leaves=True)) is PUT_DOWN
    assert kind_that(Handling(takes=True, leaves=True)) is CARRY
