"""What a forklift can do in a context, as the log that doing it would leave.

An action starts where the context's log starts: the agent and every object at their
first poses. It is kinematic: the vehicle follows its way exactly, what is on the forks
keeps its pose relative to them, and everything else stands still. The pace and the manoeuvres
(approach straight, lift, back out, lower, set down, back off) follow the logs of the
AAAI-11 corpus.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from g3.actions.action_log import (
    DEFAULT_PACE,
    Outcome,
    Pace,
    Stage,
    action_log,
    drive,
    lift,
    recorded,
    start_pose,
)
from g3.actions.driving import Obstacles, Way, arc, direction, dock, route, straight
from g3.geometry.plane import convex_hull, cross, hull_centre, point_gap, rotate
from g3.groundings import Context, FloatArray, PhysicalObject, Prism, Trajectory

REACH_M = 1.1
"""From the agent's position straight ahead to the middle of what is on the forks."""
LIFT_M = 0.3
"""How high loads are lifted off whatever they stand on, and carried over the ground."""
RUN_IN_M = 2.5
BACK_OUT_M = 1.0
BACK_OFF_M = 2.5
SIDE_ENTRY_M = 5.0
"""What entering a load across its own axis costs, in metres of way."""
STAND_OFF_M = 2.5
CARRY_OUT_M = 2.5
"""A load that is to be carried away is backed out further by this."""
MIN_CLEAR_M = 0.15
"""Loads are raised to clear what they are put down on by less than this."""
START_S, FIND_S, AIM_S, PAUSE_S, RAISE_S = 8.0, 66.0, 12.0, 8.0, 30.0
"""Waits before driving anywhere, before entering a load, before the forks move it, before
driving on with it, and before it is raised to something high."""
SETTLE_M = 0.4
_BORDER_M2 = 1e-9
_Point: TypeAlias = tuple[float, ...]
HANGING_M = 0.1
MOVED_OFF_M = 0.5


def loaded(context: Context) -> str | None:
    """Which object is on the forks when the log starts, if any.

    One that is straight ahead within reach and either stands on nothing, or moves with
    the agent when the agent first moves.
    """
    agent, start = context.agent.trajectory, start_pose(context)
    things = recorded(context).objects
    middles = np.array([centre(thing.prism) for thing in things]).reshape(-1, 2)
    offsets = rotate(middles - start[:2], np.full(len(things), -start[2]))
    for thing, offset in zip(things, offsets.tolist(), strict=True):
        near = 0.5 < offset[0] < REACH_M + 0.3 and abs(offset[1]) < 0.4
        if near and (_hangs(context, thing) or _goes_along(thing.trajectory, agent)):
            return thing.id
    return None


def drive_to(
    context: Context,
    target: Prism,
    gap_m: float | None = STAND_OFF_M,
    pace: Pace = DEFAULT_PACE,
) -> Outcome:
    """Drive up to something and face it, or drive into a free place.

    Parameters
    ----------
    target
        Footprint of the object or the place.
    gap_m
        Metres between the agent's position and the target's border at the end; None to
        end in the middle of the target.
    """
    footprint, middle = convex_hull(target.xy), centre(target)
    start = start_pose(context)
    edge = footprint[1] - footprint[0]
    ahead = middle - start[:2]
    headings = np.append(_quarters(np.arctan2(edge[1], edge[0])), np.arctan2(ahead[1], ahead[0]))
    back = np.zeros(len(headings))
    if gap_m is not None:
        back = np.array([_stand_off(footprint, middle, h, gap_m) for h in headings])
    goals = np.column_stack((middle - back[:, None] * direction(headings), headings))
    way = route(start, goals, _obstacles(context, loaded(context))).way
    return _driven(context, way, pace)


def drive_along(context: Context, waypoints: npt.ArrayLike, pace: Pace = DEFAULT_PACE) -> Outcome:
    """Drive through points, shape (k, 2), smoothly."""
    points = np.asarray(waypoints, dtype=float)
    pose = start_pose(context)
    obstacles = _obstacles(context, loaded(context))
    corners = np.vstack((pose[:2], points))
    way: list[FloatArray] = []
    for i in range(1, len(corners)):
        onward = corners[min(i + 1, len(corners) - 1)] - corners[i - 1]
        goal = np.array([[*corners[i], np.arctan2(onward[1], onward[0])]])
        legs = route(pose, goal, obstacles).way
        # A leg that goes on forwards needs no stop at the waypoint.
        if way and len(legs) == 1:
            way[-1] = np.concatenate((way[-1], legs[0][1:]))
        else:
            way.extend(legs)
        pose = way[-1][-1]
    return _driven(context, tuple(way), pace)


def drive_past(
    context: Context,
    target: Prism,
    gap_m: float = 2.0,
    beyond_m: float = 4.0,
    pace: Pace = DEFAULT_PACE,
) -> Outcome:
    """Drive past something, on the side that the agent faces, and on beyond it.

    Parameters
    ----------
    gap_m
        Metres between the agent's position and the target's widest point.
    beyond_m
        How far to go on behind it.
    """
    start, middle = start_pose(context), centre(target)
    ahead = middle - start[:2]
    axis = direction(np.arctan2(ahead[1], ahead[0]))
    side = np.array([-axis[1], axis[0]])
    width = np.abs((target.xy - middle) @ side).max() + gap_m
    left = cross(axis, direction(start[2])) >= 0
    abeam = middle + (width if left else -width) * side
    depth = np.abs((target.xy - middle) @ axis).max()
    return drive_along(context, [abeam, abeam + (depth + beyond_m) * axis], pace)


def turn(
    context: Context, angle: float, radius_m: float = 2.0, pace: Pace = DEFAULT_PACE
) -> Outcome:
    """Turn by an angle in radians, counter-clockwise if positive, driving an arc."""
    fraction = np.linspace(0, 1, max(int(np.ceil(abs(angle) * 20)), 1) + 1)
    leg = arc(start_pose(context), np.array(radius_m * abs(angle)), np.array(angle), fraction)
    return _driven(context, (leg,), pace)


def back_up(context: Context, distance_m: float, pace: Pace = DEFAULT_PACE) -> Outcome:
    """Drive straight back."""
    return _driven(context, (straight(start_pose(context), -distance_m),), pace)


def pick_up(context: Context, object_id: str, pace: Pace = DEFAULT_PACE) -> Outcome:
    """Drive to an object, lift it, and back out a little.

    Raises
    ------
    ValueError
        If something is on the forks already.
    """
    thing = _object(context, object_id)
    stages = _picked(context, thing)
    out = straight(stages[-1].poses[-1], -BACK_OUT_M)
    return action_log(context, (*stages, drive(out, LIFT_M)), thing, pace)


def carry(context: Context, object_id: str, place: Prism, pace: Pace = DEFAULT_PACE) -> Outcome:
    """Pick an object up, drive it to a place, put it down there and back off.

    Parameters
    ----------
    place
        Where its middle is to stand; its bottom comes to stand on what is there.

    Raises
    ------
    ValueError
        If something is on the forks already.
    """
    thing = _object(context, object_id)
    picked = _picked(context, thing)
    grip = picked[-1].poses[-1]
    out = drive(straight(grip, -BACK_OUT_M - CARRY_OUT_M), LIFT_M)
    low = lift(out, min(LIFT_M, _ground(context) + LIFT_M - thing.prism.z_min))
    put = _put(context, thing, grip, low, place)
    return action_log(context, (*picked, out, low, *put), thing, pace)


def put_down(context: Context, object_id: str, place: Prism, pace: Pace = DEFAULT_PACE) -> Outcome:
    """Drive the load that is on the forks at the start to a place and put it down there.

    Parameters
    ----------
    place
        As in :func:`carry`.

    Raises
    ------
    ValueError
        If the object is not on the forks.
    """
    if loaded(context) != object_id:
        raise ValueError(f"object {object_id} is not on the forks in context {context.id}")
    thing, start = _object(context, object_id), start_pose(context)
    return action_log(
        context, _put(context, thing, start, drive(start[None], 0.0), place), thing, pace
    )


def _picked(context: Context, thing: PhysicalObject) -> tuple[Stage, ...]:
    """Drive up to an object and lift it."""
    held = loaded(context)
    if held is not None:
        raise ValueError(f"object {held} is on the forks already in context {context.id}")
    headings = _quarters(float(thing.trajectory.yaw[0]))
    finals = np.column_stack((centre(thing.prism) - REACH_M * direction(headings), headings))
    sideways = np.array([0.0, SIDE_ENTRY_M, 0.0, SIDE_ENTRY_M])
    obstacles, around = _obstacles(context, None), _obstacles(context, thing.id)
    way = dock(
        start_pose(context), finals, obstacles, around=around, run_in_m=RUN_IN_M, penalty=sideways
    ).way
    drives = (*(drive(leg, None) for leg in way[:-1]), drive(way[-1], None, FIND_S))
    return (*drives, lift(drives[-1], LIFT_M, AIM_S))


def _put(
    context: Context, thing: PhysicalObject, grip: FloatArray, before: Stage, place: Prism
) -> tuple[Stage, ...]:
    """Drive a load to a place, put it down parallel to what stands next to it, back off.

    Parameters
    ----------
    grip
        Pose of the agent in which the load is where it was first.
    """
    assert before.rise is not None  # noqa: S101 - the callers hold a load
    neighbour = _neighbour(context, thing, place)
    turned = thing.trajectory.yaw[0] - grip[2]
    headings = _quarters(float(neighbour.trajectory.yaw[0] - turned) if neighbour else grip[2])
    offset = rotate(centre(thing.prism) - grip[:2], np.array(-grip[2]))
    middle = centre(place) - rotate(np.repeat(offset[None], 4, axis=0), headings)
    finals = np.column_stack((middle, headings))
    obstacles = _obstacles(context, thing.id)
    way = dock(before.poses[-1], finals, obstacles, around=obstacles, run_in_m=RUN_IN_M).way
    carried = float(before.rise[-1])
    bottom = _bottom(context, thing, place) - thing.prism.z_min
    stages = [drive(way[0], carried, PAUSE_S), *(drive(leg, carried) for leg in way[1:-1])]
    if carried < bottom + MIN_CLEAR_M:
        carried = bottom + LIFT_M
        stages.append(lift(stages[-1], carried, RAISE_S))
    stages.append(drive(way[-1], carried, PAUSE_S))
    stages.append(lift(stages[-1], bottom, AIM_S))
    return (*stages, drive(straight(stages[-1].poses[-1], -BACK_OFF_M), None))


def _driven(context: Context, way: Way, pace: Pace) -> Outcome:
    held = loaded(context)
    load = None if held is None else _object(context, held)
    rise = None if load is None else 0.0
    first, *rest = way
    stages = (drive(first, rise, START_S), *(drive(leg, rise) for leg in rest))
    return action_log(context, stages, load, pace)


def _object(context: Context, object_id: str) -> PhysicalObject:
    return next(o for o in recorded(context).objects if o.id == object_id)


def centre(prism: Prism) -> FloatArray:
    """The middle of a footprint, shape (2,)."""
    return hull_centre(prism.xy)


def covers(prism: Prism, point: FloatArray, margin_m: float = 0.0) -> bool:
    """Whether a point (2,) lies in a footprint or within a margin of it, in metres."""
    x, y = float(point[0]), float(point[1])
    (x_min, y_min), (x_max, y_max), edges = _outline(prism.xy.tobytes())
    if x < x_min - margin_m or x > x_max + margin_m or y < y_min - margin_m or y > y_max + margin_m:
        return False
    inwards = min(ex * (y - cy) - ey * (x - cx) for cx, cy, ex, ey in edges)
    if inwards >= 0 and x_min <= x <= x_max and y_min <= y <= y_max:
        return True
    if inwards < -_BORDER_M2 and margin_m == 0:
        return False
    return bool(point_gap(point[None, None], convex_hull(prism.xy)[None])[0, 0] <= margin_m)


# The same things are asked for many points, one by one.
@lru_cache(maxsize=1 << 14)
def _outline(corners: bytes) -> tuple[_Point, _Point, tuple[_Point, ...]]:
    """Least and largest x and y of corners (k, 2), and corners and edges of their hull."""
    xy = np.frombuffer(corners).reshape(-1, 2)
    hull = convex_hull(xy)
    edges = np.column_stack((hull, np.roll(hull, -1, axis=0) - hull))
    low, high = xy.min(axis=0).tolist(), xy.max(axis=0).tolist()
    return tuple(low), tuple(high), tuple(map(tuple, edges.tolist()))


def _obstacles(context: Context, but: str | None) -> Obstacles:
    return [convex_hull(o.prism.xy) for o in recorded(context).objects if o.id != but]


def _quarters(yaw: float) -> FloatArray:
    return np.asarray(yaw + np.pi / 2 * np.arange(4), dtype=np.float64)


def _ground(context: Context) -> float:
    return float(context.agent.trajectory.xyz[0, 2])


def _surfaces(context: Context, load: PhysicalObject, place: Prism) -> FloatArray:
    """Heights that a load can stand on at a place: the ground and the tops of objects."""
    middle = centre(place)
    tops = [
        o.prism.z_max
        for o in recorded(context).objects
        if o.id != load.id and covers(o.prism, middle)
    ]
    return np.array([_ground(context), *tops])


def _bottom(context: Context, load: PhysicalObject, place: Prism) -> float:
    """Height that a load put down at a place comes to stand on.

    The bottom of the place, or what is there to stand on if that is near: the bottoms
    of annotated places are seldom exact.
    """
    surfaces = _surfaces(context, load, place)
    nearest = float(surfaces[np.argmin(np.abs(surfaces - place.z_min))])
    return nearest if abs(nearest - place.z_min) < SETTLE_M else place.z_min


def _neighbour(context: Context, load: PhysicalObject, place: Prism) -> PhysicalObject | None:
    """The object nearest to a place, apart from the load."""
    middle = centre(place)[None, None]
    return min(
        (o for o in recorded(context).objects if o.id != load.id),
        key=lambda o: float(point_gap(middle, convex_hull(o.prism.xy)[None])[0, 0]),
        default=None,
    )


def _stand_off(footprint: FloatArray, middle: FloatArray, heading: float, gap_m: float) -> float:
    """How far back from the middle a heading keeps its gap to a footprint, in metres."""
    reach = float(np.linalg.norm(footprint - middle, axis=1).max()) + gap_m
    back = np.arange(0.0, reach + 0.05, 0.05)
    points = middle - back[:, None] * direction(np.array(heading))
    gaps = point_gap(points[None], footprint[None])[0]
    return float(back[np.argmax(gaps >= gap_m - 1e-9)]) if (gaps >= gap_m).any() else reach


def _hangs(context: Context, thing: PhysicalObject) -> bool:
    """Whether an object stands neither on the ground nor on another object."""
    above = thing.prism.z_min - _surfaces(context, thing, thing.prism)
    return bool((np.abs(above) > HANGING_M).all())


def _goes_along(thing: Trajectory, agent: Trajectory) -> bool:
    """Whether an object keeps its place relative to the agent when that first moves off."""
    travelled = np.linalg.norm(agent.xyz[:, :2] - agent.xyz[0, :2], axis=1)
    if len(thing) == 1 or travelled.max() < MOVED_OFF_M:
        return False
    i = int(np.argmax(travelled >= MOVED_OFF_M))
    j = max(int(np.searchsorted(thing.t, agent.t[i], side="right")) - 1, 0)
    before = rotate(thing.xyz[0, :2] - agent.xyz[0, :2], -agent.yaw[0])
    after = rotate(thing.xyz[j, :2] - agent.xyz[i, :2], -agent.yaw[i])
    return bool(np.linalg.norm(after - before) < MOVED_OFF_M / 2)


__all__ = [
    "Outcome",
    "Pace",
    "back_up",
    "carry",
    "centre",
    "covers",
    "drive_along",
    "drive_past",
    "drive_to",
    "loaded",
    "pick_up",
    "put_down",
    "recorded",
    "turn",
]
