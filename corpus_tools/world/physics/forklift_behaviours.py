"""Behaviours of the forklift's actions: driving, handling loads, and poses to things."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import compress, islice
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from corpus_tools.world.physics.behaviours import ActionError, Goal, Load, Robot, behaviour
from corpus_tools.world.physics.pacing import CAREFUL
from corpus_tools.world.physics.room import (
    FORKS_OUTLINE,
    NUDGE_M,
    READY_MARGIN_M,
    STRAIGHT_MARGIN_M,
    Support,
    axis_of,
    behind,
    boxes_of,
    carrier_under,
    fits,
    fits_straight,
    forks_band,
    load_rect,
    ready_behind,
    robot_outline,
    spots,
    support_at,
)
from corpus_tools.world.planning.curves import Motion, end_of, poses_on
from corpus_tools.world.planning.ways import NoWayError, clearance, outline, plan, room
from corpus_tools.world.state import dimensions as sizes
from corpus_tools.world.state import robot_script
from corpus_tools.world.state.dimensions import CHASSIS, FORK_LENGTH, HEEL_X
from corpus_tools.world.state.recording import heading
from corpus_tools.world.state.robot_script import (
    DRIVE_AWAY,
    FACE,
    LINE_UP,
    LOWER_FORKS,
    PARK,
    PICK_UP,
    PUT_DOWN,
    RAISE_FORKS,
    TURN_AWAY,
)
from corpus_tools.world.state.start import HEEL_GAP_M
from corpus_tools.world.state.thing_kinds import kind_of
from g3.actions.courses import direction, quarters
from g3.actions.forklift_actions import AWAY_M, SIDE_ENTRY_M, VEER_COST_M, VEERS
from g3.geometry.footprints import centre
from g3.geometry.plane import cross, rotate, wrap
from g3.groundings import FloatArray, Place

STAND_OFF_M = 0.8
"""Distance from the tips of the forks, or the load on them, to the object ahead at a stop."""
PAST_M = (1.0, 0.6, 1.6, 2.4)
"""Room beside an object that is passed, in the order in which it is tried."""
BEYOND_M = 3.0
SHIFT_COST = 20.0
"""Cost of a metre away from the middle of a place, in metres of way."""

_MIDDLE = np.array([(CHASSIS[0][0] + HEEL_X) / 2, 0.0])
"""Middle of the robot's body without its forks."""
_BODY = np.array([[x, y] for x in (CHASSIS[0][0], HEEL_X) for y in CHASSIS[1]])


@behaviour(robot_script.DRIVE_TO)
def drive_to(robot: Robot, place: Place) -> Goal:
    """Drive into a place and stop with the robot's body in its middle."""
    middle = centre(place.prism)
    ahead = middle - robot.pose[:2]
    headings = np.append(quarters(axis_of(place)), np.arctan2(ahead[1], ahead[0]))
    goals, costs = [], []
    around, boxes = robot_outline(robot, robot.load), boxes_of(robot)
    for yaw in headings:
        for shift in spots(place, rotate(_BODY - _MIDDLE, np.full(len(_BODY), yaw))):
            xy = middle + shift - rotate(_MIDDLE, yaw)
            pose = np.array([*xy, yaw])
            if clearance(pose[None], around, boxes) >= READY_MARGIN_M:
                goals.append(pose)
                costs.append(SHIFT_COST * float(np.hypot(*shift)))
                break
    if not goals:
        raise ActionError(f"there is no room for the robot in {_named(place)}")
    return gone(robot, np.array(goals), f"to {_named(place)}", np.array(costs))


@behaviour(robot_script.APPROACH)
def approach(robot: Robot, thing: str) -> Goal:
    """Stop in front of one of an object's sides, or on the way to it, facing it."""
    middle, _, axis = footprint(robot, thing)
    toward = middle - robot.pose[:2]
    headings = np.append(quarters(axis), np.arctan2(toward[1], toward[0]))
    return gone(robot, in_front(robot, thing, headings), f"up to {thing}", np.zeros(len(headings)))


def in_front(robot: Robot, thing: str, headings: FloatArray) -> FloatArray:
    """Return poses in front of an object with the robot towards its middle, shape (h, 3)."""
    middle, corners, _ = footprint(robot, thing)
    reach = HEEL_X + FORK_LENGTH
    if robot.load is not None:
        reach = max(reach, load_rect(robot.load, robot.shape(robot.load.id)).x[1])
    ahead = direction(headings)
    near = ((corners - middle) @ ahead.T).min(axis=0)
    goals = middle + (near - STAND_OFF_M - reach)[:, None] * ahead
    return np.column_stack((goals, headings))


@behaviour(robot_script.DRIVE_PAST)
def drive_past(robot: Robot, thing: str) -> Goal:
    """Drive past an object, rather on the side that the robot faces, and on beyond it."""
    middle, corners, axis = footprint(robot, thing)
    x, y = middle - robot.pose[:2]
    toward = float(np.arctan2(y, x))
    turned = np.abs(wrap(quarters(axis) - toward))
    headings = [toward, *quarters(axis)[np.argsort(turned, kind="stable")][:3].tolist()]
    around, boxes = robot_outline(robot, robot.load), boxes_of(robot)
    for yaw in headings:
        for goals in _past(middle, corners, yaw, robot.pose):
            if clearance(goals, around, boxes) < READY_MARGIN_M:
                continue
            try:
                first, _ = plan(robot.pose, goals[:1], around, boxes)
                second, _ = plan(goals[0], goals[1:], around, boxes)
            except NoWayError:
                continue
            robot.drive((*first, *second))
            return robot_goal(robot, goals[1])
    raise ActionError(f"there is no way past {thing}")


@behaviour(robot_script.TURN)
def turn(robot: Robot, angle_deg: float) -> Goal:
    """Turn on the spot."""
    return straight_or_turn(robot, (0.0, math.radians(angle_deg)), "turn")


@behaviour(robot_script.FORWARD)
def forward(robot: Robot, distance_m: float) -> Goal:
    """Drive straight ahead."""
    return straight_or_turn(robot, (distance_m, 0.0), "drive ahead")


@behaviour(robot_script.BACK_UP)
def back_up(robot: Robot, distance_m: float) -> Goal:
    """Drive straight back."""
    return straight_or_turn(robot, (-distance_m, 0.0), "back up")


@behaviour(robot_script.WAIT)
def wait(robot: Robot, duration_s: float) -> None:
    """Stand still."""
    robot.wait(duration_s)


def go(robot: Robot, goals: FloatArray, where: str, penalty: FloatArray) -> int:
    """Drive to the pose of `goals`, shape (g, 3), that is cheapest to reach, and return its index.

    `where` that is, for errors, is a preposition and a name. `penalty` is the cost of choosing
    each, in metres of way, shape (g,).
    """
    try:
        way, chosen = plan(
            robot.pose, goals, robot_outline(robot, robot.load), boxes_of(robot), penalty
        )
    except NoWayError as error:
        raise ActionError(f"the robot can't get {where}: {error}") from error
    robot.drive(way)
    return chosen


def gone(robot: Robot, goals: FloatArray, where: str, penalty: FloatArray) -> Goal:
    """Drive as :func:`go` does, and return the robot's goal."""
    return robot_goal(robot, goals[go(robot, goals, where, penalty)])


def _past(
    middle: FloatArray, corners: FloatArray, yaw: float, pose: FloatArray
) -> Iterator[FloatArray]:
    """Yield poses (2, 3) beside an object and beyond it, along a heading."""
    ahead, left = direction(np.array(yaw)), direction(np.array(yaw + np.pi / 2))
    depth, width = np.abs((corners - middle) @ np.column_stack((ahead, left))).max(axis=0)
    side = 1.0 if cross(ahead, direction(pose[2])) >= 0 else -1.0
    for gap in PAST_M:
        for sign in (side, -side):
            abeam = middle + sign * (width + CHASSIS[1][1] + gap) * left
            beyond = abeam + (depth + BEYOND_M) * ahead
            yield np.array([[*abeam, yaw], [*beyond, yaw]])


def straight_or_turn(robot: Robot, motion: Motion, what: str) -> Goal:
    """Drive straight, or turn on the spot, if nothing is in the way."""
    start = robot.pose
    poses = poses_on(start, (motion,))
    around, boxes = robot_outline(robot, robot.load), boxes_of(robot)
    margin = min(STRAIGHT_MARGIN_M, clearance(start[None], around, boxes) - 0.005)
    if clearance(poses, around, boxes) < margin:
        raise ActionError(f"the robot can't {what} that far: something is in the way")
    robot.drive((motion,))
    return robot_goal(robot, end_of(start, motion))


def robot_goal(robot: Robot, pose: FloatArray) -> Goal:
    """Return the goal that the robot is at a pose (3,)."""
    return Goal(robot.start.agent_id, np.array([*pose[:2], robot.ground_m]), float(pose[2]))


def footprint(robot: Robot, thing: str) -> tuple[FloatArray, FloatArray, float]:
    """Return middle (2,), corners (4, 2) and heading of an object that isn't on the forks."""
    if robot.load is not None and robot.load.id == thing:
        raise ActionError(f"{thing} is on the forks")
    i = robot.index(thing)
    boxes = boxes_of(robot, *(item.id for j, item in enumerate(robot.start.objects) if j != i))
    corners = boxes.corners().reshape(-1, 2)
    yaw = float(boxes.yaw[0])
    local = rotate(corners, np.full(len(corners), -yaw))
    middle = rotate((local.min(axis=0) + local.max(axis=0)) / 2, np.array(yaw))
    return middle, corners, yaw


def _named(place: Place) -> str:
    return place.name or "the place"


CARRY_M = 0.12
"""Height of carried loads above the ground, in metres."""
CLEAR_M = 0.15
"""Height of loads above their support, or above the surface that they go onto, in metres."""
LOOSE_M = 0.02
"""Height to which loads are lifted to test whether they come up, in metres."""
ENTER_M, LEAVE_M = sizes.FORK_LENGTH + 0.25, 0.5
"""Straight ways in metres: of forks into and out of a load, and of loads out, at least."""
NARROWEST_M = 2 * (sizes.FORK_Y + sizes.FORK_WIDTH / 2 + sizes.BLOCK) + 0.02
"""Loads must be so wide for the forks to find their openings."""
EPSILON_M = 0.02
"""Height above a load's support, in metres, below which a thing is not in its way."""
LONG_COST_M = 5.0
"""Cost of lifting a load lengthwise, in metres of way: it reaches less far over decks."""
SETTLE_S = 0.3
AT_ONCE = 64
"""Number of spots that are looked at together: numpy is slow for one."""


_Spot: TypeAlias = tuple[FloatArray, FloatArray, FloatArray]
"""Distance of a spot from a place's middle, pose of a load's frame there, and the robot's pose."""


@dataclass(frozen=True, slots=True, eq=False)
class _Docking:
    """A pose that the robot goes straight into and out of, with its goal and cost."""

    final: FloatArray
    """Pose at which it stops inside."""
    run_in_m: float
    run_out_m: float
    """Lengths of the straight ways in and out, in metres."""
    goal: Goal
    """Pose of the load afterwards."""
    cost: float
    """Cost of choosing it, in metres of way."""


@behaviour(PICK_UP)
def pick_up(robot: Robot, thing: str) -> Goal:
    """Drive up to a load, put the forks in, lift it, and back out with it."""
    if robot.load is not None:
        raise ActionError(
            f"the robot can't pick up {thing}: {robot.load.id} is on the forks already",
            fix="put it down before",
        )
    if not kind_of(robot.start.objects[robot.index(thing)].labels).carriable:
        raise ActionError(f"the forks can't lift {thing}")
    bottom = _bottom(robot, thing)
    carrier = carrier_under(robot, thing)
    docking = _dock(robot, _to_pick(robot, thing, bottom), f"to {thing} to pick it up", carrier)
    robot.lift(bottom)
    robot.grip, robot.support = thing, carrier
    robot.drive(((docking.run_in_m, 0.0),), CAREFUL)
    touching = bottom + sizes.ENTRY_HEIGHT - sizes.LOW
    robot.lift(touching + LOOSE_M)
    robot.take(thing)
    if _bottom(robot, thing) < bottom + LOOSE_M / 2:
        raise ActionError(f"{thing} did not come up with the forks")
    robot.lift(touching + CLEAR_M)
    robot.drive(((-docking.run_out_m, 0.0),), CAREFUL)
    robot.support = None
    robot.lift(sizes.ENTRY_HEIGHT - sizes.LOW + CARRY_M)
    return docking.goal


@behaviour(PUT_DOWN)
def put_down(robot: Robot, place: Place) -> Goal:
    """Put the load on the forks down on the support in the middle of a place, and back off.

    Where the middle is taken or out of reach, the load goes to the free spot of the place
    that is nearest to it. Forks reach over a deck as far as the load on them is long.
    """
    if robot.load is None:
        raise ActionError("nothing is on the forks to put down", fix="pick something up before")
    support = support_at(robot, place)
    where = f"to put {robot.load.id} down in {place.name or 'the place'}"
    docking = _dock(robot, _to_put(robot, robot.load, place, support), where, support.carrier)
    standing = support.height + sizes.ENTRY_HEIGHT - sizes.LOW
    if robot.forks_m < standing + CLEAR_M / 2:
        robot.lift(standing + CLEAR_M)
    robot.support = support.carrier
    robot.drive(((docking.run_in_m, 0.0),), CAREFUL)
    robot.lift(support.height)
    robot.load = None
    robot.wait(SETTLE_S)
    robot.drive(((-docking.run_out_m, 0.0),), CAREFUL)
    robot.grip = robot.support = None
    robot.lift(0.0)
    return docking.goal


def _dock(robot: Robot, dockings: list[_Docking], where: str, carrier: str | None) -> _Docking:
    """Drive to the start of one of several dockings."""
    if not dockings:
        reach = "" if carrier is None else f"the forks don't reach so far over {carrier}, or "
        raise ActionError(f"the robot can't get {where}: {reach}there is no room to go in and out")
    ready = np.array([behind(d.final, d.run_in_m) for d in dockings])
    return dockings[go(robot, ready, where, np.array([d.cost for d in dockings]))]


def _to_pick(robot: Robot, thing: str, bottom: float) -> list[_Docking]:
    """Return the dockings by which the forks can lift a load."""
    shape, (xyz, orientation) = robot.shape(thing), robot.body_pose(thing)
    yaw = float(heading(orientation))
    middle = xyz[:2] + rotate(shape.middle[:2], np.array(yaw))
    others, everything = boxes_of(robot, thing), boxes_of(robot)
    band = (bottom + EPSILON_M, bottom + CLEAR_M + float(shape.size[2]))
    ways = []
    for side, entry in enumerate(quarters(yaw)):
        long, wide = shape.size[:2] if side % 2 == 0 else shape.size[1::-1]
        if wide < NARROWEST_M:
            continue
        final = np.array(
            [*(middle - (sizes.HEEL_X + HEEL_GAP_M + long / 2) * direction(entry)), entry]
        )
        held = Load(thing, rotate(xyz[:2] - final[:2], -entry), yaw - float(entry))
        load = outline((load_rect(held, shape),))
        run_in = ready_behind(final, robot_outline(robot, None), everything, ENTER_M)
        run_out = ready_behind(final, robot_outline(robot, held), others, LEAVE_M)
        if run_in is None or run_out is None:
            continue
        goes_in = fits_straight(
            final, run_in, others, FORKS_OUTLINE, forks_band(bottom + sizes.LOW)
        )
        if goes_in and fits_straight(final, run_out, others, load, band):
            xy = xyz[:2] - run_out * direction(entry)
            z = robot.ground_m + CARRY_M - float(shape.low[2])
            goal = Goal(thing, np.array([*xy, z]), yaw)
            cost = run_in + run_out + (LONG_COST_M if long > wide + EPSILON_M else 0.0)
            ways.append(_Docking(final, run_in, run_out, goal, cost))
    return ways


def _to_put(robot: Robot, load: Load, place: Place, support: Support) -> list[_Docking]:
    """Return the dockings for putting the load down in a place, as near to its middle as can be."""
    shape, boxes, height = robot.shape(load.id), boxes_of(robot), support.height
    rect = load_rect(load, shape)
    corners = np.array([[x, y] for x in rect.x for y in rect.y])
    around = robot_outline(robot, load)
    carried = np.concatenate((FORKS_OUTLINE, outline((rect,))))
    band = (height + EPSILON_M, height + CLEAR_M + float(shape.size[2]))
    ways = []
    for yaw in quarters(support.axis):
        entry = yaw - load.yaw
        inside = rotate(corners - corners.mean(axis=0), np.full(4, entry))
        off, ahead = rotate(shape.middle[:2], yaw), rotate(load.xy, entry)
        candidates = (
            (shift, xy, np.array([*(xy - ahead), entry]))
            for shift in spots(place, inside)
            if support.holds(centre(place.prism) + shift)
            for xy in (centre(place.prism) + shift - off,)
        )
        fits_here = partial(fits, boxes=boxes, carried=carried, band=band)
        for shift, xy, final in _fitting(candidates, fits_here):
            run_in = ready_behind(final, around, boxes, ENTER_M)
            run_out = ready_behind(final, robot_outline(robot, None), boxes, ENTER_M)
            if run_in is None or run_out is None:
                continue
            out = fits_straight(
                final, run_out, boxes, FORKS_OUTLINE, forks_band(height + sizes.LOW)
            )
            if out and fits_straight(final, run_in, boxes, carried, band):
                near = float(np.hypot(*shift)) <= NUDGE_M + 1e-9
                at = xy - shift if near else xy
                z = robot.ground_m + height - float(shape.low[2])
                cost = run_in + run_out + SHIFT_COST * float(np.hypot(*shift))
                goal = Goal(load.id, np.array([*at, z]), float(yaw))
                ways.append(_Docking(final, run_in, run_out, goal, cost))
                break
    return ways


def _fitting(
    spots: Iterator[_Spot], fits: Callable[[FloatArray], npt.NDArray[np.bool_]]
) -> Iterator[_Spot]:
    """Yield the spots at which the robot has room, in their order."""
    while some := list(islice(spots, AT_ONCE)):
        yield from compress(some, fits(np.array([final for *_, final in some])))


def _bottom(robot: Robot, thing: str) -> float:
    """Return the height of an object's underside above the ground."""
    return float(robot.body_pose(thing)[0][2] + robot.shape(thing).low[2] - robot.ground_m)


NOTHING_M = 1e-3
"""Forks that are so near to a height are there."""


@behaviour(RAISE_FORKS)
def raise_forks(robot: Robot, distance_m: float) -> None:
    """Raise the forks by a distance, or as far as they go."""
    _brought_to(robot, min(robot.forks_m + distance_m, sizes.LIFT_RANGE))


@behaviour(LOWER_FORKS)
def lower_forks(robot: Robot, distance_m: float) -> None:
    """Lower the forks by a distance, or as far as they go; a load stays off the ground."""
    lowest = 0.0 if robot.load is None else sizes.ENTRY_HEIGHT - sizes.LOW + CARRY_M
    _brought_to(robot, min(max(robot.forks_m - distance_m, lowest), robot.forks_m))


def _brought_to(robot: Robot, height_m: float) -> None:
    if abs(height_m - robot.forks_m) > NOTHING_M:
        robot.lift(height_m)


SHORTER = np.array([1.0, 0.7, 0.4])
"""Shares of the way away from an object that are tried, if there is no room for all of it."""
SHORT_COST_M = 10.0
"""Cost of having none of that way, in metres of way."""
BESIDE_M = (0.8, 0.5, 1.2)
"""Room between an object and the robot beside it, in the order in which it is preferred."""


@behaviour(FACE)
def face(robot: Robot, thing: str) -> Goal:
    """Turn on the spot until the robot faces an object."""
    return _turned_to(robot, _bearing(robot, thing), f"face {thing}")


@behaviour(TURN_AWAY)
def turn_away(robot: Robot, thing: str) -> Goal:
    """Turn on the spot until an object is behind the robot."""
    return _turned_to(robot, _bearing(robot, thing) + math.pi, f"turn away from {thing}")


def _bearing(robot: Robot, thing: str) -> float:
    """Return the heading in which the robot sees an object."""
    middle, _, _ = footprint(robot, thing)
    x, y = middle - robot.pose[:2]
    return float(np.arctan2(y, x))


def _turned_to(robot: Robot, yaw: float, what: str) -> Goal:
    """Turn the shorter way round, or the other one if something is in it."""
    short = float(wrap(np.array(yaw - robot.pose[2])))
    try:
        return straight_or_turn(robot, (0.0, short), what)
    except ActionError:
        return straight_or_turn(robot, (0.0, short - math.copysign(math.tau, short)), what)


@behaviour(DRIVE_AWAY)
def drive_away(robot: Robot, thing: str) -> Goal:
    """Drive some metres away from an object, with it behind the robot."""
    veers, shares = (a.reshape(-1) for a in np.meshgrid(VEERS, SHORTER))
    headings = _bearing(robot, thing) + math.pi + veers
    goals = robot.pose[:2] + AWAY_M * shares[:, None] * direction(headings)
    cost = VEER_COST_M * np.abs(veers) + SHORT_COST_M * (1 - shares)
    return _gone_where_free(robot, goals, headings, f"away from {thing}", cost)


@behaviour(LINE_UP)
def line_up(robot: Robot, thing: str) -> Goal:
    """Stop in front of a side of an object, square to it."""
    _, _, axis = footprint(robot, thing)
    headings = quarters(axis)
    is_load = kind_of(robot.start.objects[robot.index(thing)].labels).carriable
    cost = np.array([0.0, SIDE_ENTRY_M, 0.0, SIDE_ENTRY_M]) * is_load
    return gone(robot, in_front(robot, thing, headings), f"in line with {thing}", cost)


@behaviour(PARK)
def park(robot: Robot, thing: str) -> Goal:
    """Stop beside an object, parallel to it."""
    middle, corners, axis = footprint(robot, thing)
    headings = np.repeat(quarters(axis), 2 * len(BESIDE_M))
    sign, gap = (a.reshape(-1) for a in np.meshgrid((1.0, -1.0), BESIDE_M, indexing="ij"))
    sign, gap = np.tile(sign, 4), np.tile(gap, 4)
    left = direction(headings + np.pi / 2)
    width = np.abs((corners - middle) @ left.T).max(axis=0)
    goals = middle + (sign * (width + CHASSIS[1][1] + gap))[:, None] * left
    cost = 2.0 * np.abs(gap - BESIDE_M[0])
    return _gone_where_free(robot, goals, headings, f"beside {thing}", cost)


def _gone_where_free(
    robot: Robot, xy: FloatArray, headings: FloatArray, where: str, cost: FloatArray
) -> Goal:
    """Drive to the cheapest of the poses in which the robot has room."""
    goals = np.column_stack((xy, headings))
    free = room(goals, robot_outline(robot, robot.load), boxes_of(robot)) >= READY_MARGIN_M
    if not free.any():
        raise ActionError(f"there is no room for the robot {where}")
    return gone(robot, goals[free], where, cost[free])
