"""Agreement between people: F scores of clauses, α and κ of choices, and disputed parts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from annotation_app.store.models import Record, TaskName
from corpus_tools.corpus.estimate import Estimate, Reason
from corpus_tools.corpus.rater_agreement import Level, fleiss_kappa, krippendorff_alpha
from g3.sdc.clauses import CHILD_FIELDS, SDC, all_words

Key: TypeAlias = tuple[str, Any]
"""A kind of choice, and what was chosen: the name of a thing, the number of a place, corners."""
CLAUSE_TYPE, WORDS, THING, PLACE, AREA = "clause type", "words", "thing", "place", "area"


CLOSE_S = 0.5
"""Largest difference of times in a video that are taken for the same, in seconds."""
FEWEST_ITEMS = 10
"""Number of items with several answers from which agreement is shown."""


class Part(NamedTuple):
    """A part of an answer that people decided, and whether they decided differently."""

    kind: str
    """`CLAUSE_TYPE`, `WORDS`, `THING` or `PLACE`."""
    what: str
    """A type, words in small letters, the name of a thing, the number of a place."""
    differs: bool
    video: str = ""
    """Video with the thing or place; empty for parts that are in no video."""


@dataclass(frozen=True, slots=True)
class Measured:
    """A measure of agreement."""

    measure: str
    value: float | None
    """Measured value, or None with a reason."""
    units: int
    """Units that two people or more answered: commands, clauses, pairs."""
    task: TaskName = ""
    answers: str = "all"
    """Task and kind of the answers measured; `annotation_app.dashboard.consensus` sets it."""
    reason: Reason = ""
    """Reason for the lack of a value, by its name in `corpus_tools.corpus.estimate`; empty if there
    is a value."""
    low: float | None = None
    high: float | None = None
    """Bounds of the interval of 95 %; None where all items agree equally."""
    items: int = 0
    """Number of items with several answers."""


def times_f(one: Sequence[float], other: Sequence[float]) -> float:
    """Return the F score of two people's times in a video.

    Two times are the same if they are at most `CLOSE_S` apart; each is matched once.
    """
    if not one and not other:
        return 1.0
    return 2.0 * matched_times(one, other) / (len(one) + len(other))


def matched_times(one: Sequence[float], other: Sequence[float]) -> int:
    """Return the number of times that two people have in common, as in :func:`times_f`."""
    matched, left = 0, list(other)
    for time in one:
        near = [t for t in left if abs(t - time) <= CLOSE_S]
        if near:
            left.remove(min(near, key=lambda t: abs(t - time)))
            matched += 1
    return matched


@dataclass(frozen=True, slots=True)
class ModelErrors:
    """Errors of a model in a study, by what people made of its suggestions."""

    task: TaskName
    source: str
    """Name of the model."""
    proposal: Literal["shown", "not shown"]
    """``shown`` if people saw the suggestion that their answers are compared with."""
    items: int
    answers: int
    parts: int
    """Parts of the suggestions, once for each answer."""
    undecided: int
    """Parts that people who saw them sent unchanged without accepting them."""
    measures: tuple[Measured, ...]


def tree_f(one: Sequence[SDC], other: Sequence[SDC]) -> float:
    """Return the F score of the clauses with their fields' content and their place in the tree.

    Two clauses are the same if these are equal: their type, the words of their figures and
    relations, the fields of their parents that they are in, and all words of these parents.
    """
    return f_score(nodes(one), nodes(other))


@dataclass(frozen=True, slots=True)
class Agreement:
    """A measure of agreement: the units of an item that are compared, and figures over all items.

    Each answer is read once and each item compared once, however many intervals are made of it.
    """

    units: Callable[[Sequence[Any]], Sequence[Any]]
    """The parts that are compared, from the answers to an item, as `read` returns them."""
    figures: Callable[[Sequence[Any]], Iterable[Measured]]
    """The figures, from the parts of all items."""
    read: Callable[[Record], Any] = lambda body: body


def figures(
    measures: Sequence[Agreement], items: Sequence[Sequence[Sequence[Any]]]
) -> Iterator[Measured]:
    """Yield the figures of items, of each of which there are the units of each measure."""
    for n, measure in enumerate(measures):
        yield from measure.figures([unit for units in items for unit in units[n]])


def choices(
    units: Callable[[Sequence[Record]], Iterable[Sequence[Any]]],
    levels: Sequence[Level] = ("nominal",),
    *,
    of: str = "",
    with_share: bool = False,
) -> Agreement:
    """Measure people's choices for each unit by Krippendorff's α and Fleiss' κ.

    Parameters
    ----------
    units
        People's choices for each part of an item, from the answers to it.
    of
        Name of the choice, if there are several.
    with_share
        True if the share of pairs that agree is shown, too.
    """
    about = f"{of}: " if of else ""

    def measured(rated: Sequence[tuple[Any, ...]]) -> Iterator[Measured]:
        for level in levels:
            alpha = krippendorff_alpha(rated, level)
            yield _figure(f"{about}Krippendorff's α, {level}", alpha, len(rated))
        yield _figure(f"{about}Fleiss' κ", fleiss_kappa(rated), len(rated))
        if with_share:
            yield share_alike(rated, f"{about}share of pairs that agree")

    return Agreement(lambda bodies: [tuple(u) for u in units(bodies) if len(u) > 1], measured)


def mean_of_pairs(
    scores: Mapping[str, Callable[[Any, Any], float | None]],
    read: Callable[[Record], Any] = lambda body: body,
) -> Agreement:
    """Measure the mean scores, by their names, of pairs of answers; None leaves a pair out."""

    def units(answers: Sequence[Any]) -> list[list[float | None]]:
        pairs = combinations(answers, 2)
        return [[score(*pair) for score in scores.values()] for pair in pairs]

    def means(pairs: Sequence[Sequence[float | None]]) -> Iterator[Measured]:
        for n, name in enumerate(scores):
            found = [score for pair in pairs if (score := pair[n]) is not None]
            value = float(np.mean(found)) if found else None
            reason: Reason = "" if found else "no overlap"
            yield Measured(f"{name}, mean over pairs", value, len(found), reason=reason)

    return Agreement(units, means, read)


def _figure(measure: str, found: Estimate, units: int) -> Measured:
    value = found.value if found.is_known else None
    return Measured(measure, value, units, reason=found.reason)


def share_alike(units: Iterable[Sequence[Hashable]], measure: str) -> Measured:
    """Return the share of pairs of people's choices for a unit that are the same."""
    pairs = [a == b for unit in units for a, b in combinations(unit, 2)]
    if not pairs:
        return Measured(measure, None, 0, reason="no overlap")
    return Measured(measure, float(np.mean(pairs)), len(pairs))


def by_clause(part: str, value: Callable[[Any], Hashable]) -> Agreement:
    """Measure people's choices for each clause, in the part of answers that has them by node."""

    def units(bodies: Sequence[Record]) -> Iterator[list[Hashable]]:
        for node in dict.fromkeys(node for body in bodies for node in body[part]):
            yield [value(body[part][node]) for body in bodies if node in body[part]]

    return choices(units)


def f_score(one: Counter[Hashable], other: Counter[Hashable]) -> float:
    """Return the F score of two annotations, given what is counted of each."""
    if one is other:
        return 1.0
    total = one.total() + other.total()
    common = sum(min(count, other.get(key, 0)) for key, count in one.items())
    return 2.0 * common / total if total else 1.0


def spans(sdcs: Sequence[SDC]) -> Counter[Hashable]:
    """Count the clauses by their types and words."""
    return Counter((sdc.type, all_words(sdc)) for sdc, _, _ in _walk(sdcs) if not sdc.is_implicit)


def nodes(sdcs: Sequence[SDC]) -> Counter[Hashable]:
    """Count the clauses by their content and their place in the tree, as in :func:`tree_f`."""
    return Counter(
        (sdc.type, sdc.words, sdc.relation, field, None if parent is None else all_words(parent))
        for sdc, field, parent in _walk(sdcs)
        if not sdc.is_implicit
    )


def _walk(sdcs: Sequence[SDC]) -> Iterator[tuple[SDC, str, SDC | None]]:
    """Yield each clause, the field it is in, and its parent."""
    pending: list[tuple[SDC, str, SDC | None]] = [(sdc, "", None) for sdc in sdcs]
    while pending:
        sdc, field, parent = pending.pop()
        yield sdc, field, parent
        pending += [(child, name, sdc) for name in CHILD_FIELDS for child in sdc.children(name)]
