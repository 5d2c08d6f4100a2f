"""Spatial description clauses (SDCs): the typed clauses of a command (section 3.1).

An SDC has a type, a figure, a relation and up to two landmarks. A *leaf* holds
only words, in its figure field; in an *internal* SDC the figure and the landmarks
are SDCs themselves and the relation holds words. The words of a field are spans of
the command that need not be contiguous: in "Put the tire pallet down" the relation
is "Put" and "down".
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Literal, get_args

from g3.short_repr import brief

SDCType = Literal["EVENT", "OBJECT", "PLACE", "PATH"]
SDC_TYPES: tuple[SDCType, ...] = get_args(SDCType)

Field = Literal["f", "r", "l", "l2"]
"""Names of the fields, as the paper's Figure 2 abbreviates them."""
CHILD_FIELDS: tuple[Field, ...] = ("f", "l", "l2")


@dataclass(frozen=True, slots=True, order=True)
class Span:
    """One word of a command and the place where it stands.

    Parameters
    ----------
    start
        Offset of the first character in the command.
    text
        The word itself, without white space.
    """

    start: int
    text: str

    @property
    def end(self) -> int:
        """Offset just after the last character."""
        return self.start + len(self.text)


@dataclass(frozen=True, slots=True)
class SDC:
    """One clause of a command.

    Parameters
    ----------
    type
        EVENT, OBJECT, PLACE or PATH.
    words
        The words of the figure field of a leaf; empty in an internal SDC and in the
        implicit figure of an imperative (the robot).
    relation
        The words of the relation field.
    figure, landmark1, landmark2
        The SDCs in the other fields; more than one where the command coordinates
        several ("on the ground, between the tires").
    """

    type: SDCType
    words: tuple[Span, ...] = ()
    relation: tuple[Span, ...] = ()
    figure: tuple[SDC, ...] = ()
    landmark1: tuple[SDC, ...] = ()
    landmark2: tuple[SDC, ...] = ()

    def __repr__(self) -> str:
        words = " ".join(span.text for span in all_words(self))
        return f"SDC({self.type!r}, {brief(words)})"

    @property
    def is_leaf(self) -> bool:
        """True if only the figure's words are filled (or nothing at all)."""
        return not (self.relation or self.figure or self.landmark1 or self.landmark2)

    @property
    def is_implicit(self) -> bool:
        """True if no field is filled: the unnamed agent of an imperative."""
        return self.is_leaf and not self.words

    def children(self, field: Field | None = None) -> tuple[SDC, ...]:
        """Return the SDCs in one field, or in all of them in the order f, l, l2."""
        if field == "f":
            return self.figure
        if field == "l":
            return self.landmark1
        if field == "l2":
            return self.landmark2
        if field == "r":
            return ()
        return (*self.figure, *self.landmark1, *self.landmark2)


def breadth_first(sdcs: Iterable[SDC]) -> Iterator[SDC]:
    """Return the clauses of a command, level by level.

    Groundings and correctness labels are lists aligned with this order: first the
    top-level clauses, then their children in the order f, l, l2, and so on.
    """
    queue = deque(sdcs)
    while queue:
        sdc = queue.popleft()
        yield sdc
        queue.extend(sdc.children())


def child_indices(sdcs: Iterable[SDC]) -> list[dict[Field, tuple[int, ...]]]:
    """Return the indices of each clause's children, both in breadth-first order."""
    nodes = list(breadth_first(sdcs))
    following = len(nodes) - sum(len(node.children()) for node in nodes)
    result: list[dict[Field, tuple[int, ...]]] = []
    for node in nodes:
        places: dict[Field, tuple[int, ...]] = {}
        for field in CHILD_FIELDS:
            count = len(node.children(field))
            if count:
                places[field] = tuple(range(following, following + count))
                following += count
        result.append(places)
    return result


def all_words(sdc: SDC) -> tuple[Span, ...]:
    """Return every word of a clause and the clauses in it, in the order of the command."""
    return tuple(
        sorted(span for node in breadth_first([sdc]) for span in (*node.words, *node.relation))
    )
