"""Actions that bring the robot to a pose to an object: facing it, away from it, beside it."""

from __future__ import annotations

import math

import numpy as np

from corpus_tools.world.physics.behaviours import ActionError, Goal, Robot, behaviour
from corpus_tools.world.physics.driving_actions import (
    footprint,
    gone,
    in_front,
    straight_or_turn,
)
from corpus_tools.world.physics.room import READY_MARGIN_M, boxes_of, robot_outline
from corpus_tools.world.planning.clearance import room
from corpus_tools.world.state.dimensions import CHASSIS
from corpus_tools.world.state.robot_script import DRIVE_AWAY, FACE, LINE_UP, PARK, TURN_AWAY
from corpus_tools.world.state.thing_kinds import kind_of
from g3.actions.courses import direction, quarters
from g3.actions.handling_kinds import SIDE_ENTRY_M
from g3.actions.pose_kinds import AWAY_M, VEER_COST_M, VEERS
from g3.geometry.plane import wrap
from g3.groundings import FloatArray

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
