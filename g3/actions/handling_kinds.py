"""The forklift's kinds of handling: forks up and down, pick up, carry, put down."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from g3.actions.action_kinds import Action, ActionKind, Focus, action_kind
from g3.actions.courses import RUN_IN_M, Course, Stops, course, entries, quarters, stops
from g3.actions.driving_kinds import driven, starts
from g3.actions.grounding_candidates import (
    free_of,
    spots_about,
    spots_of_robot,
    standing,
)
from g3.actions.logged_actions import REACH_M
from g3.actions.motions import LIFT_M
from g3.actions.robot_state import State, centres, is_load
from g3.geometry.footprints import centre
from g3.geometry.plane import rotate
from g3.groundings import FloatArray, PhysicalObject

BACK_OUT_M = 1.0
CARRY_OUT_M = 2.5
"""A load that is to be carried away is backed out further by this."""
BACK_OFF_M = 2.5
SIDE_ENTRY_M = 5.0
"""Cost of entering a load across its own axis, in metres of way."""
RAISE_M = 1.0
HIGHEST_M = 2.0
"""Largest height of the forks."""


def _move_forks(state: State, actions: Sequence[Action]) -> Course:
    """Stay, while the forks go up or down with what is on them."""
    lead = np.repeat(starts(state, actions), 2, axis=1)
    return driven(state, lead, lift=np.array([a.amount for a in actions]))


def _raising(state: State, focus: Focus) -> list[Action]:
    """Raise the forks, with what is on them."""
    up = min(focus.amounts.metres or RAISE_M, HIGHEST_M - state.forks_m)
    return [Action(RAISE_FORKS, object_id=state.held or "", amount=up)] if up > 0 else []


def _lowering(state: State, focus: Focus) -> list[Action]:
    """Lower the forks; what is on them stays off the ground."""
    lowest = LIFT_M if state.held else 0.0
    down = min(lowest - state.forks_m, 0.0)
    if focus.amounts.metres:
        down = max(down, -focus.amounts.metres)
    return [Action(LOWER_FORKS, object_id=state.held or "", amount=down)]


RAISE_FORKS = action_kind("raise forks", _move_forks, unit="m", on_request=True, moves_forks=True)(
    _raising
)
LOWER_FORKS = action_kind("lower forks", _move_forks, unit="m", on_request=True, moves_forks=True)(
    _lowering
)


def _loads(state: State, focus: Focus) -> list[str]:
    return [i for i in focus.themes if is_load(state, i)]


def _picking_up(state: State, focus: Focus) -> list[Action]:
    """Drive up to a load, lift it and back out."""
    return [Action(PICK_UP, object_id=i) for i in _loads(state, focus)]


def _pick_up(state: State, actions: Sequence[Action]) -> Course:
    """Up to a load, lift it, and back out."""
    ids = [a.object_id for a in actions]
    return course(starts(state, actions), ids, _picks(state, ids, BACK_OUT_M), grip=0)


def _picks(state: State, ids: Sequence[str], out: float) -> Stops:
    """Return poses for picking up loads and backing out by a distance."""
    things = [state.thing(i) for i in ids]
    middle = centres([o.prism for o in things])
    headings = quarters(np.array([o.trajectory.yaw[0] for o in things]))
    finals, blocked = entries(middle, headings, _reaches(ids), middles(state, None))
    penalty = blocked + np.array([0.0, SIDE_ENTRY_M, 0.0, SIDE_ENTRY_M])
    return stops(finals, penalty, run_in=RUN_IN_M, out=out)


def _reaches(ids: Sequence[str]) -> FloatArray:
    """Return positions of loads on the forks, in the robot's frame."""
    return np.tile([REACH_M, 0.0], (len(ids), 1))


def middles(state: State, but: str | None) -> FloatArray:
    """Middles of what stands in the way of a robot on the ground."""
    others = [o for o in state.context.objects if o.id not in (but, state.context.agent_id)]
    return centres([o.prism for o in others])


PICK_UP = action_kind("pick up", _pick_up, takes=True)(_picking_up)


def _carrying(state: State, focus: Focus) -> list[Action]:
    """Pick a load up, carry it to a place and put it down there."""
    return _put(CARRY, state, focus, _loads(state, focus))


def _carry(state: State, actions: Sequence[Action]) -> Course:
    """Pick a load up and put it down elsewhere."""
    ids = [a.object_id for a in actions]
    middle, headings, down = _spots(state, actions)
    put_at = entries(middle, headings, _reaches(ids), middles(state, None))
    return course(
        starts(state, actions),
        ids,
        _picks(state, ids, BACK_OUT_M + CARRY_OUT_M),
        stops(*put_at, run_in=RUN_IN_M, out=BACK_OFF_M),
        grip=0,
        drop=1,
        down=down,
    )


def _spots(state: State, actions: Sequence[Action]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Middles and headings of places, and how high they are over where the loads were."""
    prisms = [a.place.prism for a in actions if a.place is not None]
    middle = centres(prisms)
    edge = np.array([p.xy[1] - p.xy[0] for p in prisms])
    yaw = np.arctan2(edge[:, 1], edge[:, 0])
    bottoms = np.array([state.thing(a.object_id).prism.z_min for a in actions])
    return middle, quarters(yaw), np.array([p.z_min for p in prisms]) - bottoms


def _put(kind: ActionKind, state: State, focus: Focus, loads: Sequence[str]) -> list[Action]:
    """Put loads where a clause may mean: at its goals, or else about the robot."""
    spots = [(i, g, s) for i, g in enumerate(focus.goals) for s in spots_about(g, state)]
    if not focus.goals:
        spots = [(-1, (), s) for s in spots_of_robot(state)]
    taken = standing([spot for *_, spot in spots], state)
    found: list[Action] = []
    for load in loads:
        free = free_of(taken, state, load)
        found += [
            Action(kind, object_id=load, place=spot, goal=goal)
            for (goal, group, spot), is_free in zip(spots, free, strict=True)
            if is_free and not any(isinstance(g, PhysicalObject) and g.id == load for g in group)
        ]
    return found


CARRY = action_kind("carry", _carry, takes=True, leaves=True)(_carrying)


def _putting_down(state: State, focus: Focus) -> list[Action]:
    """Put the load on the forks down in a place."""
    if state.held is None or (focus.has_theme and state.held not in focus.themes):
        return []
    return _put(PUT_DOWN, state, focus, [state.held])


def _put_down(state: State, actions: Sequence[Action]) -> Course:
    """Drive the load on the forks to a place and put it down."""
    ids = [a.object_id for a in actions]
    middle, headings, down = _spots(state, actions)
    load = state.thing(ids[0])
    reach = rotate(centre(load.prism) - state.pose[:2], -state.pose[2])
    put_at = entries(middle, headings, np.tile(reach, (len(ids), 1)), middles(state, load.id))
    spot = stops(*put_at, run_in=RUN_IN_M, out=BACK_OFF_M)
    return course(starts(state, actions), ids, spot, drop=0, down=down)


PUT_DOWN = action_kind("put down", _put_down, leaves=True)(_putting_down)
