"""Kinds of actions: their requirements, effects and trajectories.

A kind is defined once, as a record: what it needs and changes (:class:`Handling`), which of its
actions are possible in a state, and their course. Search, hard negatives, scripts of physics and
simulated workers speak of the same records; :mod:`g3.actions.forklift_actions` has the forklift's.
The state that an action leads to follows from its trajectory.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from g3.actions import motions
from g3.actions.courses import Course, join_courses
from g3.actions.logged_actions import NOTHING, Handling, Outcome
from g3.actions.motions import Motions
from g3.actions.robot_state import State, moved_to, with_moved
from g3.groundings import Grounding, PhysicalObject, Place, Trajectory
from g3.registry import Registry, summary_of
from g3.short_repr import short_repr

Group = tuple[Grounding, ...]


@short_repr
@dataclass(frozen=True, slots=True)
class Action:
    """Something to do.

    Parameters
    ----------
    object_id
        Id of the thing that is picked up, carried or put down; empty for none.
    target
        The thing or place that is driven to, past, around or between.
    amount
        Radians to turn, metres to drive straight on or away from a thing, metres that the forks
        go up, seconds to wait; zero to drive away or wait as far or long as is usual.
    goal
        Index of the action's goal among the goals that the clause may mean; -1 for none.
    """

    kind: ActionKind
    object_id: str = ""
    target: Group = ()
    place: Place | None = None
    amount: float = 0.0
    goal: int = -1


@short_repr
@dataclass(frozen=True, slots=True)
class Amounts:
    """Amounts that a command specifies; None where it doesn't.

    Parameters
    ----------
    metres
        Distance to go, or of the forks to go up or down.
    radians
        Angle to turn, either way.
    seconds
        Time to wait.
    """

    metres: float | None = None
    radians: float | None = None
    seconds: float | None = None


@short_repr
@dataclass(frozen=True, slots=True)
class Focus:
    """Candidates of the arguments that a clause's actions are about.

    Parameters
    ----------
    themes
        Ids of the objects that it may act on; none where it names no object.
    goals
        Candidates of its goal: places, or things.
    landmarks
        Other things in its words that could be driven to.
    asked
        Kinds that its words request.
    amounts
        Distances, angles or times in its words.
    """

    themes: tuple[str, ...] = ()
    goals: tuple[Group, ...] = ()
    has_theme: bool = False
    landmarks: tuple[Group, ...] = ()
    asked: frozenset[ActionKind] = frozenset()
    amounts: Amounts = field(default_factory=Amounts)


Propose = Callable[[State, Focus], list[Action]]
CourseMaker = Callable[[State, Sequence[Action]], Course]
Unit = Literal["", "rad", "m", "s"]


@dataclass(frozen=True, slots=True, eq=False)
class ActionKind:
    """A kind of action.

    Parameters
    ----------
    name
        Unique.
    propose
        Lists its actions that are possible in a state, for a clause.
    course
        Returns the courses of its actions, those of a batch at once.
    description
        Its effect, from the proposing function's docstring.
    handling
        Its effect on a load. One that takes a load needs free forks, one that only leaves it needs
        a load on them.
    aims
        True if it goes somewhere by a target.
    unit
        Unit of its amount; empty if it has none.
    on_request
        True if it is only done where words ask for it: nobody faces a thing for nothing.
    moves_forks
        True if its amount is the height that the forks go up.
    """

    name: str
    propose: Propose
    course: CourseMaker
    description: str
    handling: Handling = NOTHING
    aims: bool = False
    unit: Unit = ""
    on_request: bool = False
    moves_forks: bool = False

    def __str__(self) -> str:
        return self.name

    def __repr__(self) -> str:
        return f"ActionKind({self.name!r})"

    def __reduce__(self) -> tuple[Callable[[str], ActionKind], tuple[str]]:
        return kind_named, (self.name,)

    @property
    def takes(self) -> bool:
        """True if it picks a load up."""
        return self.handling.takes

    @property
    def leaves(self) -> bool:
        """True if it puts a load down."""
        return self.handling.leaves

    @property
    def handles(self) -> bool:
        """True if it handles a load."""
        return self.takes or self.leaves

    def fits(self, state: State) -> bool:
        """Check that the load on the forks allows it."""
        return not self.handles or (state.held is None) == self.takes

    def forks_after(self, before_m: float, amount: float) -> float:
        """Return the height of the forks after one of its actions, in metres."""
        if self.leaves:
            return 0.0
        if self.takes:
            return motions.LIFT_M
        return before_m + amount if self.moves_forks else before_m


KINDS: Registry[ActionKind] = Registry("action", "g3.actions")
"""All kinds by name."""


def action_kind(
    name: str,
    course: CourseMaker,
    *,
    takes: bool = False,
    leaves: bool = False,
    aims: bool = False,
    unit: Unit = "",
    on_request: bool = False,
    moves_forks: bool = False,
) -> Callable[[Propose], ActionKind]:
    """Register a kind of action; decorates the function that proposes its actions.

    Parameters
    ----------
    name, course, aims, unit, on_request, moves_forks
        As of :class:`ActionKind`.
    takes, leaves
        Its effect on a load.

    Raises
    ------
    ValueError
        If another kind has the name.
    """

    def register(propose: Propose) -> ActionKind:
        described, handling = summary_of(propose), Handling(takes, leaves)
        kind = ActionKind(
            name, propose, course, described, handling, aims, unit, on_request, moves_forks
        )
        return KINDS.add(kind)

    return register


def kind_named(name: str) -> ActionKind:
    """Return the kind with a name."""
    return KINDS[name]


def kind_that(handling: Handling) -> ActionKind:
    """Return the first kind with an effect on a load: the kind that a log shows."""
    return next(kind for kind in KINDS.values() if kind.handling == handling)


def possible_actions(state: State, focus: Focus) -> list[Action]:
    """Return the actions that a clause may mean in a state, each once."""
    meant = (k for k in KINDS.values() if not k.on_request or k in focus.asked)
    fitting = (kind for kind in meant if kind.fits(state))
    proposed = (action for kind in fitting for action in kind.propose(state, focus))
    seen: dict[tuple[object, ...], Action] = {}
    for action in proposed:
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
        of_kind = [i for i, a in enumerate(actions) if a.kind is kind]
        if of_kind:
            order += of_kind
            parts.append(kind.course(state, [actions[i] for i in of_kind]))
    course = join_courses(parts)
    objects = state.context.objects
    index = {o.id: i for i, o in enumerate(objects)}
    load = np.array([index.get(i, -1) for i in course.load], dtype=np.intp)
    tracks = [objects[max(i, 0)].trajectory for i in load]
    first = np.array([[*t.xyz[0], t.yaw[0]] for t in tracks])
    ground = float(state.context.agent.trajectory.xyz[0, 2])
    moved = motions.sampled(course, ground, load, first)
    back = np.argsort(order)
    return Motions(*(getattr(moved, name)[back] for name in Motions.__slots__))


def result(state: State, action: Action, motion: Motions, row: int) -> State:
    """Return the state that an action leads to."""
    robot = state.context.agent
    pose = np.array([*motion.xyz[row, -1, :2], motion.yaw[row, -1]])
    moved = {robot.id: moved_to(robot, pose, robot.prism.z_min)}
    load = int(motion.load[row])
    if load >= 0:
        thing = state.context.objects[load]
        rise = motion.load_xyz[row, -1, 2] - thing.trajectory.xyz[0, 2]
        pose = np.array([*motion.load_xyz[row, -1, :2], motion.load_yaw[row, -1]])
        moved[thing.id] = moved_to(thing, pose, thing.prism.z_min + float(rise))
    taken = action.object_id if action.kind.takes else state.held
    forks_m = action.kind.forks_after(state.forks_m, action.amount)
    return with_moved(state, moved, None if action.kind.leaves else taken, forks_m)


def agent_of(state: State, motion: Motions, row: int) -> PhysicalObject:
    """Return the robot with the trajectory of an action."""
    agent = state.context.agent
    t = agent.trajectory.t[0] + motion.t[row]
    return replace(agent, trajectory=Trajectory(t, motion.xyz[row], motion.yaw[row]))


def outcomes(state: State, actions: Sequence[Action]) -> Iterator[Outcome]:
    """Return the logs that actions would leave, in their order."""
    motion = move(state, actions)
    for row, load in enumerate(motion.load):
        agent = agent_of(state, motion, row)
        track = Trajectory(agent.trajectory.t, motion.load_xyz[row], motion.load_yaw[row])
        objects = (
            replace(o, trajectory=track) if i == load else o
            for i, o in enumerate(state.context.objects)
        )
        yield Outcome(agent, tuple(o for o in objects if o.id != agent.id))
