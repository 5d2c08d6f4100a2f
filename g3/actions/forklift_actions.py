"""The forklift's kinds of actions: driving, handling loads, and poses to things."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from g3.actions import motions
from g3.actions.action_kinds import Action, ActionKind, Focus, Group, action_kind
from g3.actions.courses import (
    BLOCKED_COST_M,
    CLEAR_M,
    RUN_IN_M,
    Course,
    Stops,
    course,
    direction,
    entries,
    quarters,
    stops,
)
from g3.actions.grounding_candidates import (
    footprint_of,
    free_of,
    spots_about,
    spots_of_robot,
    standing,
)
from g3.actions.logged_actions import REACH_M
from g3.actions.motions import LIFT_M
from g3.actions.robot_state import State, centres, is_load
from g3.geometry.footprints import centre, covers
from g3.geometry.plane import length, padded, point_gap, rotate, wrap
from g3.geometry.relations import in_frame
from g3.groundings import FloatArray, Path, PhysicalObject, Place

__all__ = [
    "BACK_UP",
    "CARRY",
    "DRIVE_AROUND",
    "DRIVE_AWAY",
    "DRIVE_BETWEEN",
    "DRIVE_PAST",
    "DRIVE_TO",
    "FACE",
    "GO_STRAIGHT",
    "LINE_UP",
    "LOWER_FORKS",
    "PARK",
    "PICK_UP",
    "PUT_DOWN",
    "RAISE_FORKS",
    "TURN",
    "TURN_AWAY",
    "WAIT",
]

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
    return turned(state, np.array([a.amount for a in actions]))


def turned(state: State, radians: FloatArray) -> Course:
    """On the spot, by so much each, shape (n,)."""
    poses = np.tile(state.pose, (len(radians), 9, 1))
    poses[..., 2] += radians[:, None] * np.linspace(0, 1, 9)
    return driven(state, poses)


def _turning(state: State, focus: Focus) -> list[Action]:
    """Turn left, right or around, by the amount in the words if there is one."""
    radians = focus.amounts.radians
    return [Action(TURN, amount=angle) for angle in ((radians, -radians) if radians else TURNS)]


TURN = action_kind("turn", _turn, unit="rad")(_turning)


def targets(state: State, focus: Focus) -> list[tuple[int, Group]]:
    """Everything that a clause may drive to, with the goal that it is."""
    ranked = [(i, g) for i, g in enumerate(focus.goals)]
    ranked += [(-1, g) for g in focus.landmarks]
    ranked += [(-1, (state.thing(i),)) for i in focus.themes]
    robot_ids = {state.context.agent_id, state.held}
    return [
        (i, group)
        for i, group in ranked
        if not any(isinstance(g, PhysicalObject) and g.id in robot_ids for g in group)
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
    robot_ids = (state.context.agent_id, state.held)
    things = (o for o in state.context.objects if o.id not in robot_ids and covers(o.prism, point))
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
    turned = rotate(padded(footprints) - middle[:, None], -yaw[:, None])
    depth, width = np.abs(turned).max(axis=1).T
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
    proposed = targets(state, focus)
    return [Action(DRIVE_BETWEEN, target=g, goal=i) for i, g in proposed if len(g) == 2]


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
    proposed: list[Action] = []
    for load in loads:
        free = free_of(taken, state, load)
        proposed += [
            Action(kind, object_id=load, place=spot, goal=goal)
            for (goal, group, spot), is_free in zip(spots, free, strict=True)
            if is_free and not any(isinstance(g, PhysicalObject) and g.id == load for g in group)
        ]
    return proposed


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
    reach = in_frame(centre(load.prism), state.pose)
    put_at = entries(middle, headings, np.tile(reach, (len(ids), 1)), middles(state, load.id))
    spot = stops(*put_at, run_in=RUN_IN_M, out=BACK_OFF_M)
    return course(starts(state, actions), ids, spot, drop=0, down=down)


PUT_DOWN = action_kind("put down", _put_down, leaves=True)(_putting_down)


AWAY_M = 6.0
VEERS = np.deg2rad([0.0, 30.0, -30.0, 60.0, -60.0])
"""Headings that lead away from a thing, beside the straight one."""
VEER_COST_M = 4.0
"""Cost of leaving by another than the straight way, in metres of way for each radian."""
BESIDE_M = 1.6
"""From a thing's side to the middle of the robot that is parked beside it."""


def _facing(state: State, focus: Focus) -> list[Action]:
    """Turn on the spot until the robot faces a thing or a place."""
    return [Action(FACE, target=group, goal=i) for i, group in targets(state, focus)]


def _turning_away(state: State, focus: Focus) -> list[Action]:
    """Turn on the spot until a thing or a place is behind the robot."""
    return [Action(TURN_AWAY, target=group, goal=i) for i, group in targets(state, focus)]


def _face(state: State, actions: Sequence[Action]) -> Course:
    """On the spot, towards the middle of a thing."""
    return turned(state, wrap(_bearings(state, actions) - state.pose[2]))


def _turn_away(state: State, actions: Sequence[Action]) -> Course:
    """On the spot, until the middle of a thing is behind."""
    return turned(state, wrap(_bearings(state, actions) + np.pi - state.pose[2]))


def _bearings(state: State, actions: Sequence[Action]) -> FloatArray:
    """Return the headings in which the robot sees the targets of actions, shape (n,)."""
    ahead = np.array([footprint_of(a.target).mean(axis=0) for a in actions]) - state.pose[:2]
    return np.arctan2(ahead[:, 1], ahead[:, 0])


FACE = action_kind("face", _face, aims=True, on_request=True)(_facing)
TURN_AWAY = action_kind("turn away", _turn_away, aims=True, on_request=True)(_turning_away)


def _leaving(state: State, focus: Focus) -> list[Action]:
    """Drive away from a thing or a place, with it behind the robot."""
    far = focus.amounts.metres or 0.0
    return [Action(DRIVE_AWAY, target=g, amount=far, goal=i) for i, g in targets(state, focus)]


def _drive_away(state: State, actions: Sequence[Action]) -> Course:
    """Drive a distance from the robot's position, straight away from a thing or nearly so."""
    headings = (_bearings(state, actions) + np.pi)[:, None] + VEERS
    far = np.array([action.amount or AWAY_M for action in actions])
    xy = state.pose[:2] + far[:, None, None] * direction(headings)
    finals = np.concatenate((xy, headings[..., None]), axis=2)
    penalty = VEER_COST_M * np.abs(VEERS) + _crowded(state, finals)
    return driven(state, starts(state, actions), stops(finals, penalty))


DRIVE_AWAY = action_kind("drive away", _drive_away, aims=True, on_request=True)(_leaving)


def _crowded(state: State, finals: FloatArray) -> FloatArray:
    """Return costs of poses (n, h, 3) near standing things, shape (n, h)."""
    things = middles(state, state.held)
    if not len(things):
        return np.zeros(finals.shape[:2])
    gaps = length(finals[:, :, None, :2] - things)
    crowded: FloatArray = BLOCKED_COST_M * (gaps.min(axis=2) < CLEAR_M)
    return crowded


def _lining_up(state: State, focus: Focus) -> list[Action]:
    """Drive in front of a side of a thing, square to it."""
    return [Action(LINE_UP, target=g, goal=i) for i, g in about_things(state, focus)]


def _line_up(state: State, actions: Sequence[Action]) -> Course:
    """Before a side of a thing, heading for its middle."""
    finals = poses_before(state, actions)[:, :4]
    penalty = np.array([_across(state, action, finals[i]) for i, action in enumerate(actions)])
    return driven(state, starts(state, actions), stops(finals, penalty + _crowded(state, finals)))


def _across(state: State, action: Action, finals: FloatArray) -> FloatArray:
    """Return costs of poses (h, 3) that face a load across its own axis, shape (h,)."""
    thing = action.target[0]
    if len(action.target) > 1 or not isinstance(thing, PhysicalObject):
        return np.zeros(len(finals))
    across = np.abs(np.sin(finals[:, 2] - thing.trajectory.yaw[0])) > np.sqrt(0.5)
    cost: FloatArray = SIDE_ENTRY_M * across * is_load(state, thing.id)
    return cost


LINE_UP = action_kind("line up", _line_up, aims=True, on_request=True)(_lining_up)


def _parking(state: State, focus: Focus) -> list[Action]:
    """Drive beside a thing, or into a place, and stop parallel to its sides."""
    return [Action(PARK, target=group, goal=i) for i, group in targets(state, focus)]


def _park(state: State, actions: Sequence[Action]) -> Course:
    """To one of a thing's sides, along it; to the middle of a place."""
    footprints = [footprint_of(action.target) for action in actions]
    middle = np.array([footprint.mean(axis=0) for footprint in footprints])
    edge = np.array([footprint[1] - footprint[0] for footprint in footprints])
    headings = quarters(np.arctan2(edge[:, 1], edge[:, 0]))
    corners = padded(footprints) - middle[:, None]
    left = headings + np.pi / 2
    width = np.abs(corners[:, None] @ direction(left)[..., None]).max(axis=(2, 3))
    aside = (width + BESIDE_M)[..., None] * direction(left)
    xy = np.concatenate((middle[:, None] + aside, middle[:, None] - aside), axis=1)
    finals = np.concatenate((xy, np.tile(headings, 2)[..., None]), axis=2)
    inside = np.array([isinstance(action.target[0], Place) for action in actions])
    finals = np.where(
        inside[:, None, None], np.tile(poses_before(state, actions)[:, :4], (1, 2, 1)), finals
    )
    return driven(state, starts(state, actions), stops(finals, _crowded(state, finals)))


PARK = action_kind("park", _park, aims=True, on_request=True)(_parking)
