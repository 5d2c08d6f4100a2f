"""The forklift's kinds of poses to a thing that words name: facing it, away from it, beside it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from g3.actions.action_kinds import Action, Focus, action_kind
from g3.actions.courses import BLOCKED_COST_M, CLEAR_M, Course, direction, quarters, stops
from g3.actions.driving_kinds import about_things, driven, poses_before, starts, targets, turned
from g3.actions.grounding_candidates import footprint_of
from g3.actions.handling_kinds import SIDE_ENTRY_M, middles
from g3.actions.robot_state import State, is_load
from g3.geometry.plane import length, padded, wrap
from g3.groundings import FloatArray, PhysicalObject, Place

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
    own = padded(footprints) - middle[:, None]
    left = headings + np.pi / 2
    width = np.abs(own[:, None] @ direction(left)[..., None]).max(axis=(2, 3))
    aside = (width + BESIDE_M)[..., None] * direction(left)
    xy = np.concatenate((middle[:, None] + aside, middle[:, None] - aside), axis=1)
    finals = np.concatenate((xy, np.tile(headings, 2)[..., None]), axis=2)
    inside = np.array([isinstance(action.target[0], Place) for action in actions])
    finals = np.where(
        inside[:, None, None], np.tile(poses_before(state, actions)[:, :4], (1, 2, 1)), finals
    )
    return driven(state, starts(state, actions), stops(finals, _crowded(state, finals)))


PARK = action_kind("park", _park, aims=True, on_request=True)(_parking)
