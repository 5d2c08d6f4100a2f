"""The actions that are possible in a state and that a clause may mean, kind by kind."""

from __future__ import annotations

import numpy as np

from g3.actions import action_trajectories as trajectories
from g3.actions.action_kinds import Action, Focus, Group, action_kind
from g3.actions.grounding_candidates import is_open, spots_about, spots_of_robot
from g3.actions.robot_state import State
from g3.geometry.plane import rotate
from g3.groundings import PhysicalObject, Place
from g3.language.lexicon.word_sets import PEOPLE

TURNS = (np.pi / 2, -np.pi / 2, np.pi)
STRAIGHT_M = 4.0
HEAVIEST_M2 = 4.0
"""Things with a larger footprint are no loads."""


@action_kind("wait", trajectories.wait)
def propose_waiting(state: State, focus: Focus) -> list[Action]:
    """Stay where the robot is."""
    return [Action("wait")]


@action_kind("go straight", trajectories.straight)
def propose_straight(state: State, focus: Focus) -> list[Action]:
    """Drive straight ahead."""
    return [Action("go straight", amount=STRAIGHT_M)]


@action_kind("back up", trajectories.straight)
def propose_backing_up(state: State, focus: Focus) -> list[Action]:
    """Drive straight back."""
    return [Action("back up", amount=-STRAIGHT_M)]


@action_kind("turn", trajectories.turn)
def propose_turning(state: State, focus: Focus) -> list[Action]:
    """Turn left, right or around."""
    return [Action("turn", amount=angle) for angle in TURNS]


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


@action_kind("drive to", trajectories.drive_to)
def propose_driving(state: State, focus: Focus) -> list[Action]:
    """Drive up to a thing, or into a place."""
    return [Action("drive to", target=group, goal=i) for i, group in _targets(state, focus)]


@action_kind("drive past", trajectories.drive_past)
def propose_passing(state: State, focus: Focus) -> list[Action]:
    """Drive past a thing and on beyond it."""
    return _about_things("drive past", state, focus)


@action_kind("drive around", trajectories.drive_past)
def propose_driving_around(state: State, focus: Focus) -> list[Action]:
    """Drive around a thing to its other side."""
    return _about_things("drive around", state, focus)


def _about_things(kind: str, state: State, focus: Focus) -> list[Action]:
    return [
        Action(kind, target=group, goal=i)
        for i, group in _targets(state, focus)
        if isinstance(group[0], PhysicalObject)
    ]


@action_kind("drive between", trajectories.drive_between)
def propose_driving_between(state: State, focus: Focus) -> list[Action]:
    """Drive through between two things."""
    return [
        Action("drive between", target=group, goal=i)
        for i, group in _targets(state, focus)
        if len(group) == 2
    ]


def _loads(state: State, focus: Focus) -> list[str]:
    """What can be picked up: small enough, and with nothing on top."""
    if state.held is not None:
        return []
    return [i for i in focus.themes if is_load(state, i)]


def is_load(state: State, object_id: str) -> bool:
    """Whether the forks can lift an object."""
    thing = state.thing(object_id)
    if object_id == state.context.agent_id or PEOPLE.intersection(thing.labels):
        return False
    corners = rotate(thing.prism.xy, np.full(len(thing.prism.xy), -thing.trajectory.yaw[0]))
    size = float(np.prod(np.ptp(corners, axis=0)))
    return size < HEAVIEST_M2


@action_kind("pick up", trajectories.pick_up)
def propose_picking_up(state: State, focus: Focus) -> list[Action]:
    """Drive up to a load, lift it and back out."""
    return [Action("pick up", object_id=i) for i in _loads(state, focus)]


@action_kind("carry", trajectories.carry)
def propose_carrying(state: State, focus: Focus) -> list[Action]:
    """Pick a load up, carry it to a place and put it down there."""
    return [
        Action("carry", object_id=i, place=place, goal=goal)
        for i in _loads(state, focus)
        for goal, place in _places(state, focus, i)
    ]


@action_kind("put down", trajectories.put_down)
def propose_putting_down(state: State, focus: Focus) -> list[Action]:
    """Put the load on the forks down in a place."""
    if state.held is None or (focus.has_theme and state.held not in focus.themes):
        return []
    return [
        Action("put down", object_id=state.held, place=place, goal=goal)
        for goal, place in _places(state, focus, state.held)
    ]


def _places(state: State, focus: Focus, load: str) -> list[tuple[int, Place]]:
    """Where a load may be put for a clause: at its goals, or else about the robot."""
    spots: list[tuple[int, Place]] = []
    for i, group in enumerate(focus.goals):
        if any(isinstance(g, PhysicalObject) and g.id == load for g in group):
            continue
        spots += [(i, spot) for spot in spots_about(group, state)]
    if not focus.goals:
        spots += [(-1, s) for s in spots_of_robot(state)]
    return [(i, place) for i, place in spots if is_open(place, state, load)]
