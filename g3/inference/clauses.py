"""What it costs an action not to be of the sort that a clause's words ask for.

With a few hundred commands most verbs and prepositions occur too rarely to learn this of each.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from g3.groundings import FloatArray
from g3.inference.actions import Action
from g3.inference.phrases import verb_class
from g3.inference.roles import is_goal
from g3.inference.tree import Tree
from g3.language.lexicon import VERBS
from g3.sdc import SDC

PUTTING = ("carry", "put down")
HANDLING = ("pick up", *PUTTING)
UNUSUAL = float(np.log(0.05))
"""What it costs that an action isn't of the sort that the verb's class names."""


def goal_scores(tree: Tree, path: int, actions: Sequence[Action]) -> FloatArray:
    """What it costs actions (n,) not to lead to the goal that a PATH names: "to the truck".

    Parameters
    ----------
    path
        The PATH; -1 for none.
    """
    if path < 0 or not is_goal(tree.nodes[path]):
        return np.zeros(len(actions))
    return np.where([a.goal < 0 for a in actions], UNUSUAL, 0.0)


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


def verb_scores(event: SDC, kinds: Sequence[str], asked: Asked = Asked()) -> FloatArray:
    """What it costs actions of some kinds (n,) that a verb doesn't name such; shape (n,).

    Who goes, turns, waits or leaves something alone handles nothing, nor does who does what isn't
    known, unless something is led somewhere. Who places something doesn't just pick it up; who
    takes something does that, and carries it only where the clause leads. Who carries something to
    a place puts it down there, and along a path may just drive there with what was on the forks
    before; but puts down what the command has had picked up, if no later clause does. Forks that
    are lowered put down what is on them. Verbs that may mean either cost nothing, but "leave it
    there" doesn't pick it up.
    """
    kind = np.array(kinds, dtype=str)
    verb = {"carrying"} if asked.subject else set(verb_class(event).split("+")) & VERBS
    still = bool(verb) and verb <= {"going", "turning", "staying"}
    if asked.spared or (still and not asked.forks):
        return np.where(np.isin(kind, HANDLING), 2 * UNUSUAL, 0.0)
    return np.where(_unusual(kind, verb, asked), UNUSUAL, 0.0)


def _unusual(  # noqa: PLR0911 - a case each
    kind: npt.NDArray[np.str_], verb: set[str], asked: Asked
) -> npt.NDArray[np.bool_]:
    handles, puts = np.isin(kind, HANDLING), np.isin(kind, PUTTING)
    leads = asked.leads and asked.theme
    moving = {"carrying", "taking"} if asked.theme else {"carrying"}
    if asked.forks:
        lowers = "placing" in verb and asked.held is not None
        return np.not_equal(kind, "put down") if lowers else handles
    if not verb:
        return handles & (not leads)
    if verb == {"carrying"} and asked.put_later:
        return puts
    if verb == {"placing"} or (verb <= moving and asked.taken and asked.leads):
        return ~puts
    if "placing" in verb and not verb & {"taking", "carrying"}:
        return np.equal(kind, "pick up")
    if verb == {"carrying"} and leads:
        drives = np.char.startswith(kind, "drive") & (asked.held is not None)
        return ~(puts | (drives & (not asked.at_place)))
    if verb == {"taking"}:
        taking = np.isin(kind, ("pick up", "carry") if leads else ("pick up",))
        return ~taking if asked.theme and asked.held is None else handles & ~taking
    return np.zeros(len(kind), dtype=bool)
