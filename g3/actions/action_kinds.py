"""What the robot can do: kinds of actions, how they look, what they lead to.

A kind is registered by a decorator on the function that proposes its actions, together with the
function that tells how they go (:mod:`g3.actions.proposals`). The state that an action leads to
follows from its trajectory.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from g3.actions import motions
from g3.actions.courses import Course, join_courses
from g3.actions.motions import Motions
from g3.actions.robot_state import State, moved_to, with_moved
from g3.groundings import Grounding, Place

Group = tuple[Grounding, ...]


@dataclass(frozen=True, slots=True)
class Action:
    """Something to do.

    Parameters
    ----------
    kind
        Name of a registered kind.
    object_id
        What is picked up, carried or put down; empty for none.
    target
        What is driven to, past, around or between.
    place
        Where a load is put down.
    amount
        Radians to turn, metres to drive straight on.
    goal
        Which of the goals that the clause may mean the action takes; -1 for none.
    """

    kind: str
    object_id: str = ""
    target: Group = ()
    place: Place | None = None
    amount: float = 0.0
    goal: int = -1


@dataclass(frozen=True, slots=True)
class Focus:
    """What a clause may be about, the candidates of its arguments.

    Parameters
    ----------
    themes
        Ids of the objects that it may act on; none where it names no object.
    goals
        What it may lead to: places, or things.
    has_theme
        Whether it names an object.
    landmarks
        What else it names that could be driven to.
    """

    themes: tuple[str, ...] = ()
    goals: tuple[Group, ...] = ()
    has_theme: bool = False
    landmarks: tuple[Group, ...] = ()


Propose = Callable[[State, Focus], list[Action]]
Move = Callable[[State, Sequence[Action]], Course]


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of action.

    Parameters
    ----------
    name
        Unique.
    propose
        Lists its actions that are possible in a state, for a clause.
    move
        Tells how they go.
    description
        What it does, from the proposing function's docstring.
    """

    name: str
    propose: Propose
    move: Move
    description: str


KINDS: dict[str, Kind] = {}
"""All kinds by name."""


def action_kind(name: str, move: Move) -> Callable[[Propose], Propose]:
    """Register a kind of action under a name, with the function that tells how they go."""

    def register(propose: Propose) -> Propose:
        if name in KINDS:
            raise ValueError(f"there is a kind of action {name!r} already")
        KINDS[name] = Kind(name, propose, move, (propose.__doc__ or "").strip().split("\n")[0])
        return propose

    return register


def possible_actions(state: State, focus: Focus) -> list[Action]:
    """What can be done in a state that a clause may mean, each action once."""
    found = (a for kind in KINDS.values() for a in kind.propose(state, focus))
    seen: dict[tuple[object, ...], Action] = {}
    for action in found:
        place = id(action.place) if action.place is not None else 0
        target = tuple(id(g) for g in action.target)
        key = (action.kind, action.object_id, target, place, action.amount, action.goal)
        seen.setdefault(key, action)
    return list(seen.values())


def move(state: State, actions: Sequence[Action]) -> Motions:
    """Trajectories of actions, in their order."""
    order: list[int] = []
    parts: list[Course] = []
    for kind in KINDS.values():
        own = [i for i, a in enumerate(actions) if a.kind == kind.name]
        if own:
            order += own
            parts.append(kind.move(state, [actions[i] for i in own]))
    course = join_courses(parts)
    objects = state.context.objects
    index = {o.id: i for i, o in enumerate(objects)}
    load = np.array([index.get(i, -1) for i in course.load], dtype=np.intp)
    tracks = [objects[max(i, 0)].trajectory for i in load]
    first = np.array([[*t.xyz[0], t.yaw[0]] for t in tracks])
    ground = float(state.context.agent.trajectory.xyz[0, 2])
    moved = motions.sampled(motions.legs(course), ground, load, first)
    back = np.argsort(order)
    return Motions(*(getattr(moved, name)[back] for name in Motions.__slots__))


def result(state: State, action: Action, motion: Motions, row: int) -> State:
    """The state that an action leads to."""
    robot = state.context.agent
    pose = np.array([*motion.xyz[row, -1, :2], motion.yaw[row, -1]])
    moved = {robot.id: moved_to(robot, pose, robot.prism.z_min)}
    load = int(motion.load[row])
    held = state.held
    if load >= 0:
        thing = state.context.objects[load]
        rise = motion.load_xyz[row, -1, 2] - thing.trajectory.xyz[0, 2]
        pose = np.array([*motion.load_xyz[row, -1, :2], motion.load_yaw[row, -1]])
        moved[thing.id] = moved_to(thing, pose, thing.prism.z_min + float(rise))
    if action.kind == "pick up":
        held = action.object_id
    elif action.kind in ("put down", "carry"):
        held = None
    return with_moved(state, moved, held)
