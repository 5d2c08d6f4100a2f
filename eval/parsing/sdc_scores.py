"""Agreement of extracted SDC trees with annotated ones (section 3.1).

A constituent is a clause, known by its type and all words in it and in the clauses below it.
The implicit robot has no words and doesn't count. Words are compared by the letters and digits
that they cover, so that it doesn't matter how either side cuts words and punctuation.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeAlias, TypeVar

from corpus_tools.corpus.estimate import Estimate, part
from g3.sdc.clauses import SDC, SDC_TYPES, Span, all_words, breadth_first
from g3.short_repr import short_repr

T = TypeVar("T")

Letters = frozenset[int]
Constituents: TypeAlias = "Counter[tuple[str, Letters]]"
NOWHERE = "-"
"""Type and field of a word in no clause."""
FIELDS = tuple(f"{type_}.{field}" for type_ in SDC_TYPES for field in ("f", "r"))


@dataclass(frozen=True, slots=True)
class Counts:
    """Sizes of two sides, and of their intersection."""

    same: int = 0
    predicted: int = 0
    gold: int = 0

    def __add__(self, other: Counts) -> Counts:
        return Counts(
            self.same + other.same, self.predicted + other.predicted, self.gold + other.gold
        )

    @property
    def precision(self) -> Estimate:
        """Share of the predicted that is correct; undefined where nothing is predicted."""
        return part(self.same, self.predicted)

    @property
    def recall(self) -> Estimate:
        """Share of the annotated that is predicted; undefined where nothing is annotated."""
        return part(self.same, self.gold)

    @property
    def f(self) -> Estimate:
        """Harmonic mean of the two; undefined where there is nothing on either side."""
        return part(2 * self.same, self.predicted + self.gold)


@short_repr
@dataclass(frozen=True, slots=True)
class Comparison:
    """One command's trees against the annotated ones.

    Parameters
    ----------
    typed, untyped
        Constituents, with and without their types.
    by_type
        Typed constituents of each type.
    segments
        Top-level clauses, matched by their words among those that both sides have in a clause.
    exact
        True if all trees are equal in types, fields and words.
    confusion
        Letters by annotated and predicted type and field of the word that they are in.
    """

    typed: Counts
    untyped: Counts
    by_type: dict[str, Counts]
    segments: Counts
    exact: bool
    confusion: Counter[tuple[str, str]]


def compare(predicted: Sequence[SDC], gold: Sequence[SDC], text: str) -> Comparison:
    """Compare a command's extracted trees with the annotated ones."""
    ours, theirs = _constituents(predicted, text), _constituents(gold, text)
    by_type: dict[str, Counts] = {
        type_: _common(_of_type(ours, type_), _of_type(theirs, type_)) for type_ in SDC_TYPES
    }
    segments = [[_letters(all_words(sdc), text) for sdc in sdcs] for sdcs in (predicted, gold)]
    shared = frozenset().union(*segments[0]) & frozenset().union(*segments[1])
    fields = [_fields(sdcs, text) for sdcs in (predicted, gold)]
    confusion = Counter(
        (fields[1].get(i, NOWHERE), fields[0].get(i, NOWHERE)) for i in {*fields[0], *fields[1]}
    )
    return Comparison(
        typed=_common(ours, theirs),
        untyped=_common(_untyped(ours), _untyped(theirs)),
        by_type=by_type,
        segments=_common(_shared(segments[0], shared), _shared(segments[1], shared)),
        exact=_shape(predicted, text) == _shape(gold, text),
        confusion=confusion,
    )


def _letters(spans: Iterable[Span], text: str) -> Letters:
    return frozenset(i for s in spans for i in range(s.start, s.end) if text[i].isalnum())


def _constituents(sdcs: Sequence[SDC], text: str) -> Constituents:
    found = ((sdc.type, _letters(all_words(sdc), text)) for sdc in breadth_first(sdcs))
    return Counter((type_, letters) for type_, letters in found if letters)


def _shared(segments: Sequence[Letters], shared: Letters) -> Counter[Letters]:
    return Counter(segment & shared for segment in segments if segment & shared)


def _untyped(constituents: Constituents) -> Counter[Letters]:
    return Counter(letters for _, letters in constituents.elements())


def _of_type(constituents: Constituents, type_: str) -> Constituents:
    return Counter({one: count for one, count in constituents.items() if one[0] == type_})


def _common(predicted: Counter[T], gold: Counter[T]) -> Counts:
    return Counts((predicted & gold).total(), predicted.total(), gold.total())


def _fields(sdcs: Sequence[SDC], text: str) -> dict[int, str]:
    return {
        i: f"{sdc.type}.{field}"
        for sdc in breadth_first(sdcs)
        for field, spans in (("f", sdc.words), ("r", sdc.relation))
        for i in _letters(spans, text)
    }


def _shape(sdcs: Sequence[SDC], text: str) -> tuple[object, ...]:
    return tuple(
        (
            sdc.type,
            _letters(sdc.words, text),
            _letters(sdc.relation, text),
            *(_shape(sdc.children(field), text) for field in ("f", "l", "l2")),
        )
        for sdc in sdcs
    )
