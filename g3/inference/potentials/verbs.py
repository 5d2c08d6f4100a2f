"""Kinds of actions that clauses ask for, by frame (:mod:`g3.inference.problem.frames`).

With a few hundred commands most verbs and prepositions occur too rarely to learn this of each.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import log
from typing import Literal

from g3.actions.forklift_actions import PUT_DOWN
from g3.geometry.plane import BoolArray
from g3.groundings import PhysicalObject
from g3.inference.potentials.cases import ActionCase
from g3.inference.potentials.potential_registry import Measured, potential
from g3.inference.problem.clause_roles import is_goal
from g3.inference.problem.frames import (
    Frame,
    frame,
    is_put_later,
    leads_aboard,
    spares,
)
from g3.inference.problem.grounding_problem import Candidate
from g3.sdc.clauses import SDCType

UNUSUAL = log(0.05)
GUESSED = log(0.2)
"""Of what an unknown verb asks for less is sure."""
_CLAUSES: tuple[SDCType, ...] = ("EVENT", "PATH")


@potential("reaches-goal", kind="action", types=_CLAUSES, roles=("goal",), weight=UNUSUAL)
def reaches_goal(case: ActionCase) -> Measured:
    """An action leads to the goal that words name: "to the truck"."""
    return case.path is not None and is_goal(case.path) and case.each(lambda a: a.goal < 0)


@dataclass(frozen=True, slots=True)
class Asked:
    """Request of a clause besides its frame, in the state that it begins in.

    Parameters
    ----------
    theme
        Whether it names what is handled.
    leads
        Whether it names where to, and no later clause puts something down.
    at_place
        Whether where to is a PLACE, not a PATH.
    onto_robot
        Whether where to is the robot itself: "load it onto your forklift".
    held
        What is on the forks.
    taken
        Whether the command itself has had that picked up, or names it as what is handled.
    sent
        Whether it says where something is in the end: "deliver it to the truck".
    spared
        Whether it says what to leave alone.
    """

    theme: bool = False
    leads: bool = False
    at_place: bool = False
    onto_robot: bool = False
    held: str | None = None
    taken: bool = False
    sent: bool = False
    spared: bool = False


Sense = Literal[
    "spared",
    "lowering",
    "own-forks",
    "still",
    "none",
    "putting",
    "placing",
    "carrying",
    "taking",
    "",
]


def _by_forks(verb: frozenset[str], asked: Asked) -> frozenset[str]:
    """Return the classes of a verb of two senses, by the load on the forks."""
    if verb == {"taking", "placing"}:  # "unload"
        return frozenset(("taking",) if asked.held is None else ("placing",))
    if verb == {"taking", "staying"}:  # "hold"
        return frozenset(("taking",) if asked.theme and asked.held is None else ("staying",))
    return verb


def sense(own: Frame, asked: Asked) -> Sense:  # noqa: PLR0911 - a case each
    """Return the sense of a clause by its frame and the state; empty for anything."""
    verb = _by_forks(own.classes, asked)
    moving = {"carrying", "taking"} if asked.theme else {"carrying"}
    if asked.spared:
        return "spared"
    if own.forks:
        return "lowering" if "placing" in verb and asked.held is not None else "own-forks"
    if not verb:
        return "none"
    if verb <= {"going", "turning", "staying"}:
        return "still"
    if verb == {"placing"} or (verb <= moving and asked.taken and asked.leads):
        return "putting"
    if "placing" in verb and not verb & {"taking", "carrying"}:
        return "placing"
    if verb == {"carrying"} and asked.leads and asked.theme:
        return "carrying"
    aboard = asked.onto_robot and asked.theme and asked.held is None
    return "taking" if aboard or verb == {"taking"} else ""


@dataclass(frozen=True, slots=True)
class _Reading:
    """Sense of a clause, and kinds of the actions; each (n,)."""

    sense: Sense
    guessed: bool
    asked: Asked
    picks: BoolArray
    carries: BoolArray
    puts: BoolArray
    handles: BoolArray
    drives: BoolArray


def _read(case: ActionCase) -> _Reading:
    tree, root, found, held = case.tree, case.root, case.found, case.state.held
    own = frame(tree, root)
    ends = found.goal_path < 0 or is_goal(tree.nodes[found.goal_path])
    onto_robot = leads_aboard(tree, own, case.state.context.agent.labels)
    asked = Asked(
        theme=found.themes != (None,)
        and not _is_thing(found.themes[0], case.state.context.agent_id),
        leads=found.goals != (None,) and not is_put_later(tree, root),
        at_place=found.goal_path < 0,
        onto_robot=onto_robot,
        held=held,
        taken=held is not None
        and (held != case.problem.state.held or (ends and _is_thing(found.themes[0], held))),
        sent=own.sends,
        spared=spares(tree, root, held),
    )
    return _Reading(
        sense(own, asked),
        own.guessed,
        asked,
        case.each(lambda a: a.kind.takes and not a.kind.leaves),
        case.each(lambda a: a.kind.takes and a.kind.leaves),
        case.each(lambda a: a.kind.leaves),
        case.each(lambda a: a.kind.handles),
        case.each(lambda a: a.kind.aims),
    )


def _is_thing(candidate: Candidate | None, name: str) -> bool:
    """Check that a candidate is the thing with an id, alone."""
    if candidate is None or len(candidate.group) != 1:
        return False
    thing = candidate.group[0]
    return isinstance(thing, PhysicalObject) and thing.id == name


def _reading(case: ActionCase, *senses: Sense) -> _Reading | None:
    """The reading of a clause whose verb asks for one of some things; None if it doesn't."""
    found = case.once(_read)
    if case.found.asked and found.sense not in ("own-forks", "lowering"):
        return None  # what the words ask for is known in more detail
    return found if found.sense in senses and not found.guessed else None


@potential("verb-still", kind="action", types=_CLAUSES, weight=2 * UNUSUAL)
def verb_still(case: ActionCase) -> Measured:
    """A verb of going, turning or waiting handles nothing."""
    found = _reading(case, "still")
    return found is not None and found.handles


@potential("verb-leave", kind="action", types=_CLAUSES, weight=2 * UNUSUAL)
def verb_leave(case: ActionCase) -> Measured:
    """A command to leave something alone handles nothing."""
    found = _reading(case, "spared")
    return found is not None and found.handles


@potential("verb-none", kind="action", types=_CLAUSES, weight=UNUSUAL)
def verb_none(case: ActionCase) -> Measured:
    """A clause that asks for nothing handles nothing, unless it says where to."""
    found = _reading(case, "none")
    return found is not None and not (found.asked.leads and found.asked.theme) and found.handles


@potential("verb-unknown", kind="action", types=_CLAUSES, weight=GUESSED)
def verb_unknown(case: ActionCase) -> Measured:
    """An unknown verb asks for what its arguments allow: "blick it onto the truck" carries."""
    found = case.once(_read)
    if not found.guessed:
        return False
    against = _AGAINST.get(found.sense)
    if against is not None:
        return against(found)
    return found.handles | ~found.drives if found.asked.leads else found.handles


@potential("verb-forks", kind="action", types=_CLAUSES, weight=UNUSUAL)
def verb_forks(case: ActionCase) -> Measured:
    """Moving the forks handles nothing; lowering them puts down what is on them."""
    found = _reading(case, "own-forks", "lowering")
    if found is None:
        return False
    down = case.each(lambda a: a.kind is PUT_DOWN)
    return ~down if found.sense == "lowering" else found.handles


@potential("verb-put", kind="action", types=_CLAUSES, weight=UNUSUAL)
def verb_put(case: ActionCase) -> Measured:
    """A verb of placing puts down, and so does moving on what was picked up before."""
    found = _reading(case, "putting")
    return found is not None and ~found.puts


@potential("verb-place", kind="action", types=_CLAUSES, weight=UNUSUAL)
def verb_place(case: ActionCase) -> Measured:
    """A verb that may mean placing doesn't just pick up: "leave it there"."""
    found = _reading(case, "placing")
    return found is not None and found.picks


@potential("verb-carry", kind="action", types=_CLAUSES, weight=UNUSUAL)
def verb_carry(case: ActionCase) -> Measured:
    """Carrying to a place ends with putting down; along a path it may just be driving."""
    found = _reading(case, "carrying")
    return found is not None and _not_carrying(found)


@potential("verb-take", kind="action", types=_CLAUSES, weight=UNUSUAL)
def verb_take(case: ActionCase) -> Measured:
    """Taking picks up, and carries only where the clause leads."""
    found = _reading(case, "taking")
    return found is not None and _not_taking(found)


def _not_carrying(found: _Reading) -> BoolArray:
    asked = found.asked
    may_drive = asked.held is not None and not (asked.at_place or asked.sent or found.guessed)
    return ~(found.puts | (found.drives & may_drive))


def _not_taking(found: _Reading) -> BoolArray:
    asked = found.asked
    leaves = found.puts if asked.held is not None and asked.at_place else found.carries
    taking: BoolArray = found.picks | (leaves & (asked.leads and asked.theme))
    return ~taking if asked.theme and asked.held is None else found.handles & ~taking


_AGAINST: dict[Sense, Callable[[_Reading], BoolArray]] = {
    "putting": lambda found: ~found.puts,
    "carrying": _not_carrying,
    "taking": _not_taking,
}
"""What goes against what an unknown verb may ask for."""
