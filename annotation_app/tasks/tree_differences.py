"""In what several people's SDC trees of a command differ: which clauses, which words."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from annotation_app.tasks.agreement import CLAUSE_TYPE, WORDS, Part
from g3.sdc.clauses import CHILD_FIELDS, SDC, Span

FIELD_WORDS = {"f": "figure", "l": "landmark", "l2": "second landmark"}


@dataclass(frozen=True, slots=True)
class MarkedClause:
    """A clause of one tree, and how it differs from the other trees."""

    number: int
    """Depth first from 1, as drawings have it."""
    depth: int
    """0 for one that stands alone."""
    type: str
    place: str
    """Field of the clause above that holds this clause; empty if it stands alone."""
    words: tuple[tuple[str, bool], ...]
    """Its own words, and whether another tree has each in no or another sort of clause."""
    notes: tuple[str, ...]
    """Other trees' versions, in plain words."""

    @property
    def differs(self) -> bool:
        """True if any other tree lacks this clause as it is."""
        return bool(self.notes)


@dataclass(frozen=True, slots=True, eq=False)
class _Clause:
    sdc: SDC
    number: int
    depth: int
    field: str
    parent: _Clause | None

    @property
    def own(self) -> frozenset[Span]:
        return frozenset((*self.sdc.words, *self.sdc.relation))


def marked(trees: Sequence[Sequence[SDC]]) -> list[tuple[MarkedClause, ...]]:
    """Return the clauses of each tree that have words, depth first, with differences marked."""
    flat = [list(_flattened(tree)) for tree in trees]
    holders = [_holders(clauses) for clauses in flat]
    return [
        tuple(
            MarkedClause(
                clause.number,
                clause.depth,
                clause.sdc.type,
                FIELD_WORDS.get(clause.field, ""),
                tuple(
                    (word.text, any(h.get(word) != holders[i][word] for h in holders))
                    for word in sorted(clause.own)
                ),
                tuple(
                    f"{note} in answer {j + 1}"
                    for j, other in enumerate(flat)
                    if j != i
                    for note in _notes(clause, other)
                ),
            )
            for clause in clauses
        )
        for i, clauses in enumerate(flat)
    ]


def disputed_parts(trees: Sequence[Sequence[SDC]]) -> Iterator[Part]:
    """Yield the types and words of all trees' clauses, marked where people differ."""
    for clauses in marked(trees):
        for clause in clauses:
            yield Part(CLAUSE_TYPE, clause.type, clause.differs)
            for word, differs in clause.words:
                yield Part(WORDS, word.lower(), differs)


def _flattened(tree: Sequence[SDC]) -> Iterator[_Clause]:
    """Yield all clauses that have words, depth first; the numbers count those without, too."""
    number = 0

    def below(sdc: SDC, depth: int, field: str, parent: _Clause | None) -> Iterator[_Clause]:
        nonlocal number
        number += 1
        clause = _Clause(sdc, number, depth, field, parent)
        if not sdc.is_implicit:
            yield clause
        for name in CHILD_FIELDS:
            for child in sdc.children(name):
                yield from below(child, depth + 1, name, clause)

    for sdc in tree:
        yield from below(sdc, 0, "", None)


def _holders(clauses: Iterable[_Clause]) -> dict[Span, tuple[str, str]]:
    """Return the type of clause that holds each word, and the field it is in."""
    return {
        word: (clause.sdc.type, field)
        for clause in clauses
        for field, words in (("f", clause.sdc.words), ("r", clause.sdc.relation))
        for word in words
    }


def _notes(clause: _Clause, others: Sequence[_Clause]) -> Iterator[str]:
    """Yield descriptions of another tree's version of a clause, where it differs."""
    other = _counterpart(clause, others)
    if other is None:
        yield "nothing like it"
        return
    if other.sdc.type != clause.sdc.type:
        yield other.sdc.type
    if other.own != clause.own:
        yield f"“{_phrase(other)}”"
    same_place = clause.field == other.field and (
        clause.parent is None
        or other.parent is None
        or _overlap(clause.parent, other.parent) > 0
        or not (clause.parent.own or other.parent.own)
    )
    if not same_place:
        yield _place(other)


def _counterpart(clause: _Clause, others: Sequence[_Clause]) -> _Clause | None:
    """Return another tree's clause with most words in common; the same type comes first."""
    likeness = {
        other: (_overlap(clause, other), other.sdc.type == clause.sdc.type) for other in others
    }
    best = max(likeness, key=lambda other: likeness[other], default=None)
    return best if best is not None and likeness[best][0] > 0 else None


def _overlap(one: _Clause, other: _Clause) -> float:
    union = one.own | other.own
    return len(one.own & other.own) / len(union) if union else 0.0


def _place(clause: _Clause) -> str:
    if clause.parent is None:
        return "it stands alone"
    return f"{FIELD_WORDS[clause.field]} of “{_phrase(clause.parent)}”"


def _phrase(clause: _Clause) -> str:
    return " ".join(word.text for word in sorted(clause.own)) or clause.sdc.type
