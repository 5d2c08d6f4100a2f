"""Checks of a plan against single words: "away from", "past", "raise the forks", "face".

They measure commands without annotations, whose outcome shows nothing of the robot's path.
Mentions are found in the text, not in the clauses, so that a clause that is read wrongly counts
against the plan. The landmark is the plan's own grounding of the next noun: its correctness is
measured elsewhere.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from g3.actions.action_kinds import Action, move, result
from g3.actions.grounding_candidates import footprint_of
from g3.actions.robot_state import State, start_state
from g3.geometry.footprints import centre
from g3.geometry.plane import point_gap, wrap
from g3.geometry.relations import PASSED_M, in_frame
from g3.groundings import Context, FloatArray, Grounding, Path, PhysicalObject
from g3.inference.grounder import Plan
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.frames import asked
from g3.inference.problem.phrases import is_measure, names_lift, names_robot
from g3.sdc.clauses import SDC, Span, all_words
from g3.short_repr import short_repr

FARTHER_M = 1.0
"""Smallest gain in distance for "away from", and distance beyond for "past", in metres."""
AT_M = 4.5
"""Largest distance at which the robot stops at something, in metres."""
STILL_M, STILL_RAD = 0.5, np.deg2rad(10)
"""Largest movement (metres) and turn (radians) of a robot that stays."""
FACING_RAD = np.deg2rad(30)
STRAIGHT_RAD = np.deg2rad(15)
"""Tolerance on the heading of a robot lined up with a landmark's side, in radians."""
ASIDE_M = 1.0
RAISED_M = 0.3
_OWN = r"(?: (?:the|your|its|up|mechanical|forklift))*"
_FORKS = r" (?:forks?|forklift|lift|prongs?)\b(?! (?:pallet|of))"


@dataclass(frozen=True, slots=True)
class Mention:
    """Words of a command that state a measurable relation."""

    relation: str
    """The stated relation, one of :data:`RELATIONS`."""
    start: int
    end: int


@short_repr
@dataclass(frozen=True, slots=True)
class Done:
    """The part of a plan that carries out the clause of a mention."""

    action: Action
    before: State
    after: State
    way: FloatArray
    """The robot's x, y, yaw, shape (n, 3)."""
    marks: tuple[Grounding, ...]
    """Landmarks that the plan chose, at their places before the action; empty without one."""

    @property
    def outline(self) -> FloatArray:
        """The landmark's footprint, shape (k, 2)."""
        return footprint_of(self.marks)

    @property
    def gaps(self) -> FloatArray:
        """Distances of the robot from the landmark, in metres, shape (n,)."""
        found: FloatArray = point_gap(self.way[None, :, :2], self.outline[None])[0]
        return found

    @property
    def bearing(self) -> float:
        """Final bearing of the landmark's middle from the robot, in radians; 0 is ahead."""
        x, y = self.outline.mean(axis=0) - self.way[-1, :2]
        return float(abs(wrap(np.arctan2(y, x) - self.way[-1, 2])))

    @property
    def stays(self) -> bool:
        """True if the robot stays in its place and handles nothing."""
        far = np.linalg.norm(self.way[:, :2] - self.way[0, :2], axis=1).max()
        turned = np.ptp(np.unwrap(self.way[:, 2]))
        return not self.action.kind.handles and bool(far <= STILL_M and turned <= STILL_RAD)


def _away(done: Done) -> bool:
    """Check that the robot, or the load that it moves, ends farther from the landmark."""
    if not done.action.kind.handles:
        return bool(done.gaps[-1] - done.gaps[0] >= FARTHER_M)
    load = done.action.object_id
    ends = np.array([centre(s.thing(load).prism) for s in (done.before, done.after)])
    first, last = point_gap(ends[None], done.outline[None])[0]
    return bool(last - first >= FARTHER_M)


def _past(done: Done) -> bool:
    """Check that the robot drives by the landmark and ends beyond it."""
    nearest = int(np.argmin(done.gaps))
    step = np.gradient(done.way[:, :2], axis=0)[nearest]
    ahead = step / max(float(np.linalg.norm(step)), 1e-9)
    beyond = (done.way[-1, :2] - done.outline.mean(axis=0)) @ ahead
    onward = (done.way[-1, :2] - done.way[0, :2]) @ ahead
    return bool(0 < done.gaps[nearest] <= PASSED_M and beyond >= FARTHER_M and onward >= FARTHER_M)


def _lined_up(done: Done) -> bool:
    """Check that the robot is parallel to a side, with the landmark straight ahead or beside."""
    thing = done.marks[0]
    if done.action.kind.handles or not isinstance(thing, PhysicalObject):
        return False
    turned = float(done.way[-1, 2] - thing.trajectory.yaw[0])
    skew = abs((turned + np.pi / 4) % (np.pi / 2) - np.pi / 4)
    ahead, left = in_frame(done.outline.mean(axis=0), done.way[-1])
    aligned = (ahead > 0 and abs(left) <= ASIDE_M) or abs(ahead) <= ASIDE_M
    return bool(skew <= STRAIGHT_RAD and aligned)


def _waits(done: Done) -> bool:
    """Check that the robot stays; with a landmark, that it stops at it."""
    if not done.marks:
        return done.stays
    return not done.action.kind.handles and bool(done.gaps[-1] <= AT_M)


def _lowers(done: Done) -> bool:
    """Check that the forks and their load end down, with no other action."""
    puts = done.before.held is not None and done.action.kind.leaves
    return (puts or done.stays) and done.after.forks_m < RAISED_M


@short_repr
@dataclass(frozen=True, slots=True)
class Relation:
    """A relation that words can state, with its check, and whether it has a landmark."""

    words: str
    """A regular expression, matched without regard to case."""
    holds: Callable[[Done], bool]
    has_landmark: bool = True


RELATIONS = {
    "turn away": Relation(r"\bturn\w*(?: \w+)? away from\b", lambda d: d.bearing >= np.pi / 2),
    "away": Relation(
        r"(?<!\bfeet )(?<!metres )(?<!meters )(?<!distance )(?<!turn )(?<!facing )\baway from\b",
        _away,
    ),
    "past": Relation(r"\bpast\b|\bpass(?:ed)?(?= (?:the|a|it|him)\b)", _past),
    "raise forks": Relation(
        rf"\b(?:raise|lift|elevate)\b{_OWN}{_FORKS}",
        lambda d: d.stays and d.after.forks_m - d.before.forks_m >= RAISED_M,
        has_landmark=False,
    ),
    "lower forks": Relation(
        rf"\b(?:lower|drop)(?:ing)?\b{_OWN}{_FORKS}", _lowers, has_landmark=False
    ),
    "face": Relation(
        (
            r"(?<!-)\b(?:face|faces|facing)\b"
            r"|\bturn(?:ing)?(?: the \w+)?(?: around)? (?:to|towards?)"
            r"(?= (?:the|a|an) (?!left|right))"
        ),
        lambda d: not d.action.kind.handles and d.bearing <= FACING_RAD,
    ),
    "line up": Relation(
        r"\baligned? (?:\w+ )?with\b|\bline up\b|\bin line with\b",
        _lined_up,
    ),
    "park": Relation(r"\bpark\b", lambda d: not d.action.kind.handles and d.gaps[-1] <= AT_M),
    "wait": Relation(
        r"(?<!the )(?<!a )\b(?:wait|stop|stopping|stay|halt|pause)\b",
        _waits,
        has_landmark=False,
    ),
}
"""Relations by name. A mention of the first that matches is no mention of the others."""


def mentions(text: str) -> Iterator[Mention]:
    """Yield a command's mentions of measurable relations, in order."""
    taken: list[Mention] = []
    for name, relation in RELATIONS.items():
        for found in re.finditer(relation.words, text, re.IGNORECASE):
            if not any(m.start < found.end() and found.start() < m.end for m in taken):
                taken.append(Mention(name, *found.span()))
    yield from sorted(taken, key=lambda m: m.start)


def fulfils_relation(mention: Mention, sdcs: Sequence[SDC], context: Context, plan: Plan) -> bool:
    """Check that a plan does what a mention states."""
    tree = Tree(tuple(sdcs))
    acts = [root for root in asked(tree) if tree.nodes[root].type in ("EVENT", "PATH")]
    # What is done for a purpose lies within the clause that it is for.
    telling = [
        root
        for root in acts
        if any(mention.start <= word.start < mention.end for word in all_words(tree.nodes[root]))
    ]
    own = min(telling, key=lambda root: len(all_words(tree.nodes[root])), default=None)
    state = start_state(context)
    for root, action in zip(acts, plan.actions, strict=True):
        motion = move(state, [action])
        after = result(state, action, motion, 0)
        if root == own:
            sdc = tree.nodes[root]
            way = np.column_stack((motion.xyz[0, :, :2], motion.yaw[0]))
            marks = _landmark(mention, sdc, plan, state)
            relation = RELATIONS[mention.relation]
            if relation.has_landmark and not marks:
                return False
            return relation.holds(Done(action, state, after, way, marks))
        state = after
    return False


def _landmark(mention: Mention, sdc: SDC, plan: Plan, state: State) -> tuple[Grounding, ...]:
    """Return the plan's groundings of the first noun after the mention in its clause."""
    own = {word.start for word in all_words(sdc)}
    after = []
    for found in plan.groundings:
        words: tuple[Span, ...] = tuple(all_words(found.sdc))
        if found.sdc.type not in ("OBJECT", "PLACE") or not words or not found.group:
            continue
        first = min(word.start for word in words)
        is_noun = not any(names(found.sdc) for names in (is_measure, names_robot, names_lift))
        if first >= mention.end and first in own and is_noun:
            after.append((first, -len(words), found.group))
    group = min(after, key=lambda a: a[:2])[2] if after else ()
    return tuple(
        state.thing(g.id) if isinstance(g, PhysicalObject) else g
        for g in group
        if not isinstance(g, Path)
    )
