"""What each word of a command does in its SDC trees, and reading that off annotated trees.

A command's trees are told by one *role* for each word and, for each clause that modifies a
noun, the noun that it modifies. Roles say where a clause begins and what it is; words go on
with it until the next begins. :mod:`g3.language.parsing.tree_assembly` puts trees together from
roles.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal, NamedTuple, get_args

from g3.sdc.clauses import SDC

Role = Literal[
    "outside",
    "noun",
    "subject",
    "noun-on",
    "event",
    "sub-event",
    "noun-event",
    "event-on",
    "modifier",
    "place",
    "path",
    "relation-on",
]
"""``noun`` begins a leaf OBJECT and ``subject`` one in the figure of an EVENT. ``event``
begins the relation of a top-level EVENT, ``sub-event`` that of one inside another clause and
``noun-event`` that of one that modifies a noun ("the trailer you *see*"). ``modifier``,
``place`` and ``path`` begin the relation of an OBJECT, a PLACE and a PATH. The roles in
``-on`` go on with the last clause of their kind, wherever its last word stands.
"""
ROLES: tuple[Role, ...] = get_args(Role)
BEGINS_EVENT = frozenset(("event", "sub-event", "noun-event"))
BEGINS_RELATION = frozenset(("modifier", "place", "path"))


class Reading(NamedTuple):
    """A command's trees as roles.

    Parameters
    ----------
    roles
        The role of each word.
    modified
        For each word that begins a clause that modifies a noun, the word that begins
        that noun.
    """

    roles: tuple[Role, ...]
    modified: dict[int, int]


def read_roles(sdcs: Sequence[SDC], starts: Sequence[int], ends: Sequence[int]) -> Reading:
    """The roles that words have in annotated trees.

    Parameters
    ----------
    sdcs
        The top-level clauses of a command.
    starts, ends
        Where the command's words begin and end.
    """
    roles: list[Role] = ["outside"] * len(starts)
    modified: dict[int, int] = {}
    begins: dict[int, int] = {}
    clauses = list(_clauses(sdcs))
    for number, clause in enumerate(clauses):
        spans = clause.sdc.words or clause.sdc.relation
        found = [
            i
            for i, role in enumerate(roles)
            if role == "outside" and any(s.start < ends[i] and starts[i] < s.end for s in spans)
        ]
        first, on = _clause_roles(clause)
        for i in found:
            roles[i] = first if i == found[0] else on
        if found:
            begins[number] = found[0]
    for number, clause in enumerate(clauses):
        noun = begins.get(clause.noun)
        if number in begins and noun is not None:
            modified[begins[number]] = noun
    return Reading(tuple(roles), modified)


class _Placed(NamedTuple):
    """A clause in its tree; `noun` numbers the leaf that it modifies, -1 if none."""

    sdc: SDC
    parent: SDC | None
    subject: bool
    noun: int


def _clause_roles(clause: _Placed) -> tuple[Role, Role]:
    sdc, parent = clause.sdc, clause.parent
    if sdc.is_leaf and sdc.type == "OBJECT":
        return ("subject" if clause.subject else "noun"), "noun-on"
    if sdc.type == "EVENT":
        if parent is None:
            return "event", "event-on"
        return ("sub-event" if clause.noun < 0 else "noun-event"), "event-on"
    if sdc.type == "OBJECT":
        return "modifier", "relation-on"
    return ("place" if sdc.type == "PLACE" else "path"), "relation-on"


def _clauses(sdcs: Sequence[SDC]) -> Iterator[_Placed]:
    """The clauses of trees, each before those inside it."""
    count = 0
    pending = [_Placed(sdc, None, False, -1) for sdc in reversed(sdcs)]
    while pending:
        clause = pending.pop()
        sdc = clause.sdc
        modifies = sdc.type == "OBJECT" and bool(sdc.relation)
        leaf = count + _steps_to_leaf(sdc)
        yield clause._replace(noun=leaf if modifies else clause.noun)
        count += 1
        bare = sdc.type == "OBJECT" and not sdc.relation and bool(sdc.figure)
        for field in ("l2", "l", "f"):
            of_event = field == "f" and (sdc.type == "EVENT" or clause.subject)
            for child in reversed(sdc.children(field)):
                subject = of_event or (modifies and field == "l" and _precedes(child, sdc))
                noun = leaf if bare and field != "f" and child.type == "EVENT" else -1
                pending.append(_Placed(child, sdc, subject, noun))


def _precedes(leaf: SDC, clause: SDC) -> bool:
    """Whether a landmark stands before its relation, as in "the tires you are holding"."""
    return leaf.is_leaf and bool(leaf.words) and leaf.words[0] < clause.relation[0]


def _steps_to_leaf(sdc: SDC) -> int:
    """How many clauses after this one the first leaf of its figure comes."""
    steps = 0
    while sdc.figure:
        sdc = sdc.figure[0]
        steps += 1
    return steps
