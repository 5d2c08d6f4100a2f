"""Actions that only drive."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from corpus_tools.world.physics.behaviours import ActionError, Goal, Robot, behaviour
from corpus_tools.world.physics.room import (
    READY_MARGIN_M,
    STRAIGHT_MARGIN_M,
    axis_of,
    boxes_of,
    load_rect,
    robot_outline,
    spots,
)
from corpus_tools.world.planning.clearance import clearance
from corpus_tools.world.planning.curves import Motion, end_of, poses_on
from corpus_tools.world.planning.ways import NoWayError, plan
from corpus_tools.world.state import robot_script
from corpus_tools.world.state.dimensions import CHASSIS, FORK_LENGTH, HEEL_X
from g3.actions.courses import direction, quarters
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
    room = min(STRAIGHT_MARGIN_M, clearance(start[None], around, boxes) - 0.005)
    if clearance(poses, around, boxes) < room:
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
