"""Phrases that a model gets right and wrong, as section 4.2 of the paper discusses them.

For each SDC type there are four lists of phrases: those that are right and predicted so
("correctly-classified high-scoring examples"), those wrong and predicted so, and both
kinds of error. A score is the model's probability of φ = True. The high-scoring errors
are false positives, the low-scoring ones false negatives, among them "SDCs with
incorrectly annotated groundings that the system actually got right".
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Literal, get_args

from rich.table import Table

from eval.table_1.correspondence import TYPES, Predictions, RowType, predicted_true
from eval.tables.formats import cell, document, table_text

Score = Literal["highest", "lowest"]
ListFormat = Literal["text", "json"]
LIST_FORMATS: tuple[ListFormat, ...] = get_args(ListFormat)

KINDS: tuple[tuple[bool, Score], ...] = (
    (True, "highest"),
    (True, "lowest"),
    (False, "highest"),
    (False, "lowest"),
)
"""The four lists: correctness of the prediction, and end of the scores."""


@dataclass(frozen=True, slots=True)
class Example:
    """An example's fields in error lists.

    Parameters
    ----------
    id
        Names the example: the annotation and the clause in it.
    source
        Source of its groundings (:data:`g3.annotation.Source`).
    """

    id: str
    words: str
    source: str


@dataclass(frozen=True, slots=True)
class Phrase:
    """A phrase and the examples of a list that have it.

    Parameters
    ----------
    words
        The words, in lower case with single spaces.
    probability
        The most extreme probability of φ = True among the examples.
    count
        Number of examples in the list with these words.
    total
        Number of examples of this SDC type with these words, however classified.
    id, source
        Fields of the example with that probability; the first by id if several have it.
    """

    words: str
    probability: float
    count: int
    total: int
    id: str
    source: str


@dataclass(frozen=True, slots=True)
class ErrorList:
    """The most extreme phrases of one type, outcome and end of the scores.

    Parameters
    ----------
    scoring
        ``highest``: predicted true, from the highest probability down; ``lowest``:
        predicted false, from the lowest up. So the lists have no example in common.
    examples
        Number of examples that the phrases were chosen from.
    """

    type: RowType
    correct: bool
    scoring: Score
    phrases: tuple[Phrase, ...]
    examples: int


def error_lists(
    predictions: Predictions,
    examples: Sequence[Example],
    *,
    k: int = 10,
    threshold: float = 0.5,
) -> tuple[ErrorList, ...]:
    """Collect the extreme phrases of each type, outcome and end of the scores.

    Parameters
    ----------
    examples
        Displayed fields of the examples, aligned, length n.
    k
        Number of different phrases in a list.

    Returns
    -------
    tuple of ErrorList
        The four :data:`KINDS` of each type in the order of Table 1; of types without
        examples the lists are empty. Phrases with equal probability are in the order of
        the alphabet.
    """
    if len(examples) != len(predictions):
        raise ValueError(f"{len(examples)} examples for {len(predictions)} predictions")
    words = [" ".join(example.words.lower().split()) for example in examples]
    predicted = predicted_true(predictions, threshold)
    correct = predicted == predictions.label
    lists = []
    for kind in TYPES:
        of_type = predictions.type == kind
        totals = Counter(words[i] for i in of_type.nonzero()[0])
        for is_correct, scoring in KINDS:
            chosen = of_type & (correct == is_correct) & (predicted == (scoring == "highest"))
            entries = [
                (words[i], float(predictions.probability[i]), examples[i])
                for i in chosen.nonzero()[0]
            ]
            phrases = _extreme(entries, totals, k, descending=scoring == "highest")
            lists.append(ErrorList(kind, is_correct, scoring, phrases, len(entries)))
    return tuple(lists)


def _extreme(
    entries: Sequence[tuple[str, float, Example]],
    totals: Mapping[str, int],
    k: int,
    *,
    descending: bool,
) -> tuple[Phrase, ...]:
    sign = -1 if descending else 1
    ranked = sorted(entries, key=lambda e: (sign * e[1], e[0], e[2].id, e[2].source))
    counts = Counter(words for words, _, _ in ranked)
    first: dict[str, Phrase] = {}
    for words, probability, example in ranked:
        if words not in first:
            first[words] = Phrase(
                words, probability, counts[words], totals[words], example.id, example.source
            )
    return tuple(first.values())[:k]


def render_lists(
    lists: Sequence[ErrorList],
    format: ListFormat,  # noqa: A002 - the name of the option
    metadata: Mapping[str, object],
    *,
    terminal: bool = False,
) -> str:
    """Render error lists as a table to read or as JSON, without a final newline.

    Parameters
    ----------
    format
        ``table``, where empty lists are left out, or ``json``.
    """
    if format == "json":
        return document({"lists": [asdict(one) for one in lists]}, metadata)
    if format == "text":
        notes = (
            "p: probability that the groundings are right",
            "n: examples in the list, of all of the type with these words",
        )
        tables = {_title(one): _table(one) for one in lists if one.phrases}
        return table_text(tables, notes, metadata, terminal=terminal)
    raise ValueError(f"{format!r} is no format, expected one of {', '.join(LIST_FORMATS)}")


def _title(one: ErrorList) -> str:
    outcome = "correct" if one.correct else "incorrect"
    title = f"{one.type}, {outcome}, {one.scoring}-scoring"
    return f"{title} (phrases: {len(one.phrases)}, of {one.examples} examples)"


def _table(one: ErrorList) -> Table:
    table = Table()
    table.add_column("p", justify="right")
    table.add_column("n", justify="right")
    for heading in ("Words", "Groundings", "Example"):
        table.add_column(heading)
    for phrase in one.phrases:
        table.add_row(
            f"{phrase.probability:.3f}",
            f"{phrase.count} of {phrase.total}",
            cell(phrase.words),
            cell(phrase.source),
            cell(phrase.id),
        )
    return table
