"""The forklift's kinds of actions: what each proposes, and where it goes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from g3.actions import motions
from g3.actions.action_kinds import Action, ActionKind, Focus, Group, action_kind
from g3.actions.courses import RUN_IN_M, Course, Stops, course, entries, stops
from g3.actions.driving import direction, quarters
from g3.actions.grounding_candidates import (
    footprint_of,
    free_of,
    spots_about,
    spots_of_robot,
    standing,
)
from g3.actions.loads import is_load
from g3.actions.logged_actions import REACH_M
from g3.actions.robot_state import State, centres, padded
from g3.geometry.footprints import centre, covers
from g3.geometry.plane import length, point_gap, rotate
from g3.groundings import FloatArray, Path, PhysicalObject

TURNS = (np.pi / 2, -np.pi / 2, np.pi)
STRAIGHT_M = 4.0
STAND_OFF_M = 2.5
PAST_M, BEYOND_M = 2.0, 4.0
BACK_OUT_M = 1.0
CARRY_OUT_M = 2.5
"""A load that is to be carried away is backed out further by this."""
BACK_OFF_M = 2.5
SIDE_ENTRY_M = 5.0
"""What entering a load across its own axis costs, in metres of way."""


def _starts(state: State, actions: Sequence[Action]) -> FloatArray:
    return np.repeat(state.pose[None, None], len(actions), axis=0)


def _driven(state: State, lead: FloatArray, *stops: Stops) -> Course:
    """With whatever is on the forks, or with nothing."""
    return course(lead, [state.held or ""] * len(lead), *stops)


def _stay(state: State, actions: Sequence[Action]) -> Course:
    """Stay."""
    return _driven(state, _starts(state, actions))


def _waiting(state: State, focus: Focus) -> list[Action]:
    """Stay where the robot is."""
    return [Action(WAIT)]


WAIT = action_kind("wait", _stay, unit="s")(_waiting)


def _straight(state: State, actions: Sequence[Action]) -> Course:
    """Straight ahead, or back."""
    amounts = np.array([a.amount for a in actions])
    return _driven(state, motions.straights(_starts(state, actions)[:, 0], amounts))


def _going_straight(state: State, focus: Focus) -> list[Action]:
    """Drive straight ahead."""
    return [Action(GO_STRAIGHT, amount=STRAIGHT_M)]


def _backing_up(state: State, focus: Focus) -> list[Action]:
    """Drive straight back."""
    return [Action(BACK_UP, amount=-STRAIGHT_M)]


GO_STRAIGHT = action_kind("go straight", _straight, unit="m")(_going_straight)
BACK_UP = action_kind("back up", _straight, unit="m")(_backing_up)


def _turn(state: State, actions: Sequence[Action]) -> Course:
    """Turn on the spot."""
    poses = np.repeat(_starts(state, actions), 9, axis=1)
    poses[..., 2] += np.array([a.amount for a in actions])[:, None] * np.linspace(0, 1, 9)
    return _driven(state, poses)


def _turning(state: State, focus: Focus) -> list[Action]:
    """Turn left, right or around."""
    return [Action(TURN, amount=angle) for angle in TURNS]


TURN = action_kind("turn", _turn, unit="rad")(_turning)


def _targets(state: State, focus: Focus) -> list[tuple[int, Group]]:
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
    return [Action(DRIVE_TO, target=group, goal=i) for i, group in _targets(state, focus)]


def _drive_to(state: State, actions: Sequence[Action]) -> Course:
    """Up to a thing, facing it; into the middle of a place, or before what stands there."""
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
    finals = np.concatenate((middle[:, None] - away, headings[..., None]), axis=2)
    return _driven(state, _starts(state, actions), stops(finals))


def _standing(state: State, point: FloatArray) -> FloatArray | None:
    """The footprint of what stands at a point; None where nothing does."""
    own = (state.context.agent_id, state.held)
    things = (o for o in state.context.objects if o.id not in own and covers(o.prism, point))
    thing = next(things, None)
    return footprint_of((thing,)) if thing else None


def _stand_offs(footprints: FloatArray, middle: FloatArray, headings: FloatArray) -> FloatArray:
    """How far before the middles of footprints the robot stops, for each heading; (n, h)."""
    far = float(length(footprints - middle[:, None]).max()) + STAND_OFF_M
    # Nearer to its middle no point is that far from a footprint.
    back = np.arange(STAND_OFF_M - 0.25, far + 0.25, 0.25)
    points = middle[:, None, None] - back[:, None] * direction(headings)[:, :, None]
    gaps = point_gap(points.reshape(len(middle), -1, 2), footprints).reshape(points.shape[:3])
    chosen: FloatArray = back[(gaps >= STAND_OFF_M - 0.1).argmax(axis=2)]
    return chosen


DRIVE_TO = action_kind("drive to", _drive_to, aims=True)(_driving)


def _about_things(state: State, focus: Focus) -> list[tuple[int, Group]]:
    return [(i, g) for i, g in _targets(state, focus) if isinstance(g[0], PhysicalObject)]


def _passing(state: State, focus: Focus) -> list[Action]:
    """Drive past a thing and on beyond it."""
    return [Action(DRIVE_PAST, target=g, goal=i) for i, g in _about_things(state, focus)]


def _going_around(state: State, focus: Focus) -> list[Action]:
    """Drive around a thing to its other side."""
    return [Action(DRIVE_AROUND, target=g, goal=i) for i, g in _about_things(state, focus)]


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
    targets = _targets(state, focus)
    return [Action(DRIVE_BETWEEN, target=g, goal=i) for i, g in targets if len(g) == 2]


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
    return _driven(state, _starts(state, actions), stops(first[:, None]), stops(last[:, None]))


DRIVE_BETWEEN = action_kind("drive between", _drive_between, aims=True)(_driving_between)


def _loads(state: State, focus: Focus) -> list[str]:
    return [i for i in focus.themes if is_load(state, i)]


def _picking_up(state: State, focus: Focus) -> list[Action]:
    """Drive up to a load, lift it and back out."""
    return [Action(PICK_UP, object_id=i) for i in _loads(state, focus)]


def _pick_up(state: State, actions: Sequence[Action]) -> Course:
    """Up to a load, lift it, and back out."""
    ids = [a.object_id for a in actions]
    return course(_starts(state, actions), ids, _picks(state, ids, BACK_OUT_M), grip=0)


def _picks(state: State, ids: Sequence[str], out: float) -> Stops:
    """Where loads are picked up, backing out by so much."""
    things = [state.thing(i) for i in ids]
    middle = centres([o.prism for o in things])
    headings = quarters(np.array([o.trajectory.yaw[0] for o in things]))
    finals, blocked = entries(middle, headings, _reaches(ids), _middles(state, None))
    penalty = blocked + np.array([0.0, SIDE_ENTRY_M, 0.0, SIDE_ENTRY_M])
    return stops(finals, penalty, run_in=RUN_IN_M, out=out)


def _reaches(ids: Sequence[str]) -> FloatArray:
    """Where loads are on the forks, in the robot's frame."""
    return np.tile([REACH_M, 0.0], (len(ids), 1))


def _middles(state: State, but: str | None) -> FloatArray:
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
    put_at = entries(middle, headings, _reaches(ids), _middles(state, None))
    return course(
        _starts(state, actions),
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
    put_at = entries(middle, headings, np.tile(reach, (len(ids), 1)), _middles(state, load.id))
    spot = stops(*put_at, run_in=RUN_IN_M, out=BACK_OFF_M)
    return course(_starts(state, actions), ids, spot, drop=0, down=down)


PUT_DOWN = action_kind("put down", _put_down, leaves=True)(_putting_down)
