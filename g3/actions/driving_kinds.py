"""The forklift's kinds of driving: straight on, turning, up to things, past, around and between."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from g3.actions import motions
from g3.actions.action_kinds import Action, Focus, Group, action_kind
from g3.actions.courses import Course, Stops, course, direction, quarters, stops
from g3.actions.grounding_candidates import footprint_of
from g3.actions.robot_state import State
from g3.geometry.footprints import centre, covers
from g3.geometry.plane import length, padded, point_gap, rotate
from g3.groundings import FloatArray, Path, PhysicalObject

TURNS = (np.pi / 2, -np.pi / 2, np.pi)
STRAIGHT_M = 4.0
STAND_OFF_M = 2.5
PAST_M, BEYOND_M = 2.0, 4.0


def starts(state: State, actions: Sequence[Action]) -> FloatArray:
    """Return the start of each action, shape (n, 1, 3)."""
    return np.repeat(state.pose[None, None], len(actions), axis=0)


def driven(state: State, lead: FloatArray, *stops: Stops, lift: FloatArray | float = 0.0) -> Course:
    """Drive with the load on the forks, or without one."""
    return course(lead, [state.held or ""] * len(lead), *stops, lift=lift)


def _stay(state: State, actions: Sequence[Action]) -> Course:
    """Stay."""
    return driven(state, starts(state, actions))


def _waiting(state: State, focus: Focus) -> list[Action]:
    """Stay where the robot is."""
    return [Action(WAIT, amount=focus.amounts.seconds or 0.0)]


WAIT = action_kind("wait", _stay, unit="s")(_waiting)


def _straight(state: State, actions: Sequence[Action]) -> Course:
    """Straight ahead, or back."""
    amounts = np.array([a.amount for a in actions])
    return driven(state, motions.straights(starts(state, actions)[:, 0], amounts))


def _going_straight(state: State, focus: Focus) -> list[Action]:
    """Drive straight ahead."""
    return [Action(GO_STRAIGHT, amount=focus.amounts.metres or STRAIGHT_M)]


def _backing_up(state: State, focus: Focus) -> list[Action]:
    """Drive straight back."""
    return [Action(BACK_UP, amount=-(focus.amounts.metres or STRAIGHT_M))]


GO_STRAIGHT = action_kind("go straight", _straight, unit="m")(_going_straight)
BACK_UP = action_kind("back up", _straight, unit="m")(_backing_up)


def _turn(state: State, actions: Sequence[Action]) -> Course:
    """Turn on the spot."""
    return turned(state, np.array([a.amount for a in actions]))


def turned(state: State, radians: FloatArray) -> Course:
    """On the spot, by so much each, shape (n,)."""
    poses = np.tile(state.pose, (len(radians), 9, 1))
    poses[..., 2] += radians[:, None] * np.linspace(0, 1, 9)
    return driven(state, poses)


def _turning(state: State, focus: Focus) -> list[Action]:
    """Turn left, right or around, by the amount in the words if there is one."""
    said = focus.amounts.radians
    return [Action(TURN, amount=angle) for angle in ((said, -said) if said else TURNS)]


TURN = action_kind("turn", _turn, unit="rad")(_turning)


def targets(state: State, focus: Focus) -> list[tuple[int, Group]]:
    """Everything that a clause may drive to, with the goal that it is."""
    found = [(i, g) for i, g in enumerate(focus.goals)]
    found += [(-1, g) for g in focus.landmarks]
    found += [(-1, (state.thing(i),)) for i in focus.themes]
    own = {state.context.agent_id, state.held}
    return [
        (i, group)
        for i, group in found
        if not any(isinstance(g, PhysicalObject) and g.id in own for g in group)
    ]


def _driving(state: State, focus: Focus) -> list[Action]:
    """Drive up to a thing, or into a place."""
    return [Action(DRIVE_TO, target=group, goal=i) for i, group in targets(state, focus)]


def _drive_to(state: State, actions: Sequence[Action]) -> Course:
    """Up to a thing, facing it; into the middle of a place, or before what stands there."""
    return driven(state, starts(state, actions), stops(poses_before(state, actions)))


def poses_before(state: State, actions: Sequence[Action]) -> FloatArray:
    """Poses before what actions aim at: four square to its sides, one on the way; (n, 5, 3)."""
    footprints = [footprint_of(action.target) for action in actions]
    middle = np.array([footprint.mean(axis=0) for footprint in footprints])
    edge = np.array([footprint[1] - footprint[0] for footprint in footprints])
    ahead = middle - state.pose[:2]
    square = quarters(np.arctan2(edge[:, 1], edge[:, 0]))
    headings = np.column_stack((square, np.arctan2(ahead[:, 1], ahead[:, 0])))
    things = [isinstance(action.target[0], PhysicalObject) for action in actions]
    blocked = [
        own if thing else _standing(state, point)
        for own, thing, point in zip(footprints, things, middle, strict=True)
    ]
    back = np.zeros(headings.shape)
    rows = [i for i, footprint in enumerate(blocked) if footprint is not None]
    if rows:
        outlines = padded([footprint for footprint in blocked if footprint is not None])
        back[rows] = _stand_offs(outlines, middle[rows], headings[rows])
    away = back[..., None] * direction(headings)
    return np.concatenate((middle[:, None] - away, headings[..., None]), axis=2)


def _standing(state: State, point: FloatArray) -> FloatArray | None:
    """Return the footprint of the thing that stands at a point; None for none."""
    own = (state.context.agent_id, state.held)
    things = (o for o in state.context.objects if o.id not in own and covers(o.prism, point))
    thing = next(things, None)
    return footprint_of((thing,)) if thing else None


def _stand_offs(footprints: FloatArray, middle: FloatArray, headings: FloatArray) -> FloatArray:
    """Return the distances before footprints at which the robot stops, for each heading; (n, h)."""
    far = float(length(footprints - middle[:, None]).max()) + STAND_OFF_M
    # Nearer to its middle no point is that far from a footprint.
    back = np.arange(STAND_OFF_M - 0.25, far + 0.25, 0.25)
    points = middle[:, None, None] - back[:, None] * direction(headings)[:, :, None]
    gaps = point_gap(points.reshape(len(middle), -1, 2), footprints).reshape(points.shape[:3])
    chosen: FloatArray = back[(gaps >= STAND_OFF_M - 0.1).argmax(axis=2)]
    return chosen


DRIVE_TO = action_kind("drive to", _drive_to, aims=True)(_driving)


def about_things(state: State, focus: Focus) -> list[tuple[int, Group]]:
    """Return the targets of a clause that are things, no places."""
    return [(i, g) for i, g in targets(state, focus) if isinstance(g[0], PhysicalObject)]


def _passing(state: State, focus: Focus) -> list[Action]:
    """Drive past a thing and on beyond it."""
    return [Action(DRIVE_PAST, target=g, goal=i) for i, g in about_things(state, focus)]


def _going_around(state: State, focus: Focus) -> list[Action]:
    """Drive around a thing to its other side."""
    return [Action(DRIVE_AROUND, target=g, goal=i) for i, g in about_things(state, focus)]


def _drive_past(state: State, actions: Sequence[Action]) -> Course:
    """Past a thing on the side that the robot faces and on; or around it, to its other side."""
    footprints = [footprint_of(action.target) for action in actions]
    middle = np.array([footprint.mean(axis=0) for footprint in footprints])
    ahead = middle - state.pose[:2]
    yaw = np.arctan2(ahead[:, 1], ahead[:, 0])
    own = rotate(padded(footprints) - middle[:, None], -yaw[:, None])
    depth, width = np.abs(own).max(axis=1).T
    aside = np.where(np.sin(state.pose[2] - yaw) >= 0, width + PAST_M, -(width + PAST_M))
    around = np.array([action.kind is DRIVE_AROUND for action in actions])
    beyond = np.column_stack(
        (
            depth + np.where(around, STAND_OFF_M, BEYOND_M),
            np.where(around, 0.0, aside),
        )
    )
    abeam = middle + rotate(np.column_stack((np.zeros(len(yaw)), aside)), yaw)
    heading = yaw + np.where(around, np.pi, 0.0)
    first = np.column_stack((abeam, yaw))
    return _through(state, actions, first, np.column_stack((middle + rotate(beyond, yaw), heading)))


DRIVE_PAST = action_kind("drive past", _drive_past, aims=True)(_passing)
DRIVE_AROUND = action_kind("drive around", _drive_past, aims=True)(_going_around)


def _driving_between(state: State, focus: Focus) -> list[Action]:
    """Drive through between two things."""
    found = targets(state, focus)
    return [Action(DRIVE_BETWEEN, target=g, goal=i) for i, g in found if len(g) == 2]


def _drive_between(state: State, actions: Sequence[Action]) -> Course:
    """Through between two things and on."""
    first, last = [], []
    for action in actions:
        a, b = (centre(g.prism) for g in action.target[:2] if not isinstance(g, Path))
        across = (b - a) / max(float(np.linalg.norm(b - a)), 1e-6)
        along = np.array([-across[1], across[0]])
        middle = (a + b) / 2
        if (middle - state.pose[:2]) @ along < 0:
            along = -along
        yaw = float(np.arctan2(along[1], along[0]))
        first.append([*(middle - along), yaw])
        last.append([*(middle + BEYOND_M * along), yaw])
    return _through(state, actions, np.array(first), np.array(last))


def _through(
    state: State, actions: Sequence[Action], first: FloatArray, last: FloatArray
) -> Course:
    """By way of some poses (n, 3) to others."""
    return driven(state, starts(state, actions), stops(first[:, None]), stops(last[:, None]))


DRIVE_BETWEEN = action_kind("drive between", _drive_between, aims=True)(_driving_between)
