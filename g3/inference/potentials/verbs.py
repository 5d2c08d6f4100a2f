"""What sort of action a clause's words ask for, by the class of its verb.

With a few hundred commands most verbs and prepositions occur too rarely to learn this of each.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log
from typing import Literal

from g3.actions.forklift_actions import CARRY, PUT_DOWN
from g3.geometry.plane import BoolArray
from g3.inference.potentials.cases import ActionCase
from g3.inference.potentials.potential_registry import Measured, potential
from g3.inference.problem.clause_roles import (
    is_goal,
    is_itself_put_later,
    is_put_later,
    names_own_forks,
    spares,
    subjects,
)
from g3.inference.problem.phrases import verb_class
from g3.language.lexicon.word_sets import VERBS
from g3.sdc.clauses import SDC, SDCType

UNUSUAL = log(0.05)
_CLAUSES: tuple[SDCType, ...] = ("EVENT", "PATH")


@potential("reaches-goal", kind="action", types=_CLAUSES, roles=("goal",), weight=UNUSUAL)
def reaches_goal(case: ActionCase) -> Measured:
    """An action leads to the goal that words name: "to the truck"."""
    return case.path is not None and is_goal(case.path) and case.each(lambda a: a.goal < 0)


@dataclass(frozen=True, slots=True)
class Asked:
    """What a clause asks for besides what its verb says.

    Parameters
    ----------
    theme
        Whether it names what is handled.
    leads
        Whether it names where to, and no later clause puts something down.
    at_place
        Whether where to is a PLACE, not a PATH.
    held
        What is on the forks.
    taken
        Whether the command itself has had that picked up.
    put_later
        Whether a later clause puts down what this one is about.
    subject
        Whether what is moved is said to be, or to go, somewhere.
    forks
        Whether it names the forks.
    spared
        Whether it says what to leave alone.
    """

    theme: bool = False
    leads: bool = False
    at_place: bool = False
    held: str | None = None
    taken: bool = False
    put_later: bool = False
    subject: bool = False
    forks: bool = False
    spared: bool = False


Sense = Literal[
    "spared",
    "lowering",
    "own-forks",
    "still",
    "unknown",
    "before-putting",
    "putting",
    "placing",
    "carrying",
    "taking",
    "",
]


def sense(event: SDC, asked: Asked) -> Sense:  # noqa: PLR0911 - a case each
    """What a clause asks for by its verb's classes and what else it says; empty for anything."""
    verb = {"carrying"} if asked.subject else set(verb_class(event).split("+")) & VERBS
    moving = {"carrying", "taking"} if asked.theme else {"carrying"}
    if asked.spared:
        return "spared"
    if asked.forks:
        return "lowering" if "placing" in verb and asked.held is not None else "own-forks"
    if verb and verb <= {"going", "turning", "staying"}:
        return "still"
    if not verb:
        return "unknown"
    if verb == {"carrying"} and asked.put_later:
        return "before-putting"
    if verb == {"placing"} or (verb <= moving and asked.taken and asked.leads):
        return "putting"
    if "placing" in verb and not verb & {"taking", "carrying"}:
        return "placing"
    if verb == {"carrying"} and asked.leads and asked.theme:
        return "carrying"
    return "taking" if verb == {"taking"} else ""


@dataclass(frozen=True, slots=True)
class _Reading:
    """What a clause asks for, and of which kinds the actions are; each (n,)."""

    sense: Sense
    asked: Asked
    picks: BoolArray
    puts: BoolArray
    handles: BoolArray
    drives: BoolArray


def _read(case: ActionCase) -> _Reading:
    tree, root, found, held = case.tree, case.root, case.found, case.state.held
    asked = Asked(
        theme=found.themes != (None,),
        leads=found.goals != (None,) and not is_put_later(tree, root),
        at_place=found.goal_path < 0,
        held=held,
        taken=held not in (None, case.problem.state.held),
        put_later=is_itself_put_later(tree, root),
        subject=bool(subjects(tree, root)),
        forks=names_own_forks(tree, root),
        spared=spares(tree, root, held),
    )
    return _Reading(
        sense(case.sdc, asked),
        asked,
        case.each(lambda a: a.kind.takes and not a.kind.leaves),
        case.each(lambda a: a.kind.leaves),
        case.each(lambda a: a.kind.handles),
        case.each(lambda a: a.kind.aims),
    )


def _reading(case: ActionCase, *senses: Sense) -> _Reading | None:
    """The reading of a clause that asks for one of some things; None if it doesn't."""
    found = case.once(_read)
    if case.found.asked and not found.asked.forks:
        return None  # what the words ask for is known in more detail
    return found if found.sense in senses else None


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


@potential("verb-unknown", kind="action", types=_CLAUSES, weight=UNUSUAL)
def verb_unknown(case: ActionCase) -> Measured:
    """A verb of no known class handles nothing, unless the clause says where to."""
    found = _reading(case, "unknown")
    return found is not None and not (found.asked.leads and found.asked.theme) and found.handles


@potential("verb-forks", kind="action", types=_CLAUSES, weight=UNUSUAL)
def verb_forks(case: ActionCase) -> Measured:
    """Moving the forks handles nothing; lowering them puts down what is on them."""
    found = _reading(case, "own-forks", "lowering")
    if found is None:
        return False
    down = case.each(lambda a: a.kind is PUT_DOWN)
    return ~down if found.sense == "lowering" else found.handles


@potential("verb-put-later", kind="action", types=_CLAUSES, weight=UNUSUAL)
def verb_put_later(case: ActionCase) -> Measured:
    """What a later clause puts down isn't put down yet."""
    found = _reading(case, "before-putting")
    return found is not None and found.puts


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
    if found is None:
        return False
    may_drive = found.asked.held is not None and not found.asked.at_place
    return ~(found.puts | (found.drives & may_drive))


@potential("verb-take", kind="action", types=_CLAUSES, weight=UNUSUAL)
def verb_take(case: ActionCase) -> Measured:
    """Taking picks up, and carries only where the clause leads."""
    found = _reading(case, "taking")
    if found is None:
        return False
    asked = found.asked
    carries = case.each(lambda a: a.kind is CARRY) & (asked.leads and asked.theme)
    taking: BoolArray = found.picks | carries
    return ~taking if asked.theme and asked.held is None else found.handles & ~taking
