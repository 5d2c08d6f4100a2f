"""Words of an SDC and labels of the semantic map (section 3.3, last paragraph)."""

from __future__ import annotations

from functools import partial

import numpy as np

from g3.features.bodies import IntArray
from g3.features.factor_batch import FactorBatch
from g3.features.feature_registry import Column, Columns, feature_set
from g3.geometry.plane import BoolArray
from g3.groundings import FloatArray
from g3.language.similarity.resources import (
    tag_table_identity,
    word_vectors_identity,
    wordnet_identity,
)
from g3.language.similarity.word_similarity import MEASURES, best_match, label_patterns, mean_match

TIE = 1e-9
"""Similarities this close are equal."""


def label_columns(batch: FactorBatch) -> Columns:
    """Make a binary column for each label of the batch."""
    return tuple(Column(name, "bool") for name in batch.bodies.label_names)


label_set = partial(feature_set, columns=label_columns, wordless=True)


@label_set("labels", types=("OBJECT",), roles=("figure",), words=("figure", "relation"))
def labels(batch: FactorBatch) -> FloatArray:
    """Labels that the semantic map gives the figure: all of it, for a plural."""
    return batch.bodies.shared_labels[batch.figure].astype(float)


def _mixed_columns(batch: FactorBatch) -> Columns:
    return tuple(Column(f"{name}.some", "bool") for name in batch.bodies.label_names)


@feature_set(
    "mixed-labels",
    types=("OBJECT",),
    roles=("figure",),
    words=("figure",),
    columns=_mixed_columns,
    scale=0.7,
    wordless=True,
)
def mixed_labels(batch: FactorBatch) -> FloatArray:
    """Labels that some, but not all, things of a plural have."""
    bodies = batch.bodies
    return (bodies.labels & ~bodies.shared_labels)[batch.figure].astype(float)


@label_set(
    "landmark-labels",
    types=("OBJECT", "PLACE", "PATH"),
    roles=("landmark",),
    words=("relation",),
    scale=0.5,
)
def landmark_labels(batch: FactorBatch) -> FloatArray:
    """Labels of the landmark: what can carry, contain or be near things."""
    return batch.bodies.labels[batch.landmark].astype(float)


@label_set("theme-labels", types=("EVENT",), roles=("theme",), words=("relation",), scale=0.2)
def theme_labels(batch: FactorBatch) -> FloatArray:
    """Labels of the object acted on: what can be picked up, moved, loaded."""
    return batch.bodies.labels[batch.theme].astype(float)


FORMS = ("exact", "lemma", "spelling")
MEANINGS = ("path", "wup", "lin")
TAGS = ("tag-npmi", "tag-given")
word_set = partial(feature_set, types=("OBJECT",), roles=("figure",), words=())
meaning_set = partial(word_set, scale=0.4)
"""They register how like a figure's words are to labels, in form and in meaning."""


def _compared(measures: tuple[str, ...]) -> Columns:
    return tuple(
        Column(f"{name}.{side}", "1", 0, 1, 5) for name in measures for side in ("own", "other")
    )


def _compare(batch: FactorBatch, measures: tuple[str, ...]) -> FloatArray:
    """Similarity of the closest word and label: of the figure, and of others in its scene."""
    names = [factor.get("name", ()) for factor in batch.words]
    vocabulary = sorted({word for words in names for word in words})
    row = {word: i for i, word in enumerate(vocabulary)}
    indices = [[row[word] for word in words] for words in names]
    similarity = np.array(
        [MEASURES[name](vocabulary, batch.bodies.label_names) for name in measures]
    )
    sides = [
        best_match(similarity, indices, factor, labels)[:, row]
        for factor, labels, row in batch.once("label sides", _label_sides)
    ]
    table: FloatArray = np.stack(sides, axis=1).reshape(-1, len(batch)).T
    return table


def _label_sides(batch: FactorBatch) -> list[tuple[IntArray, BoolArray, IntArray]]:
    """Labels of the figure, and those that only others in its scene have.

    For each of the two: factors and labels of the pairs of them that differ, and which of
    these each row has.
    """
    labels = batch.bodies.labels
    figure_labels = labels[batch.figure]
    peers = labels[batch.peers] & (batch.peers >= 0)[..., None]
    other = (peers.any(axis=1) | labels[batch.agent_body]) & ~figure_labels
    sides = []
    for side in (figure_labels, other):
        patterns, pattern = label_patterns(side)
        pair = batch.factor * len(patterns) + pattern
        different, row = np.unique(pair, return_inverse=True)
        factor, place = np.divmod(different, len(patterns))
        sides.append((factor, patterns[place], row.reshape(-1)))
    return sides


@word_set("word-form", columns=_compared(FORMS))
def word_form(batch: FactorBatch) -> FloatArray:
    """Likeness in form of the figure's words to its labels, and to others in its scene."""
    return batch.shared(_form, "figure", words=True)


_form = partial(_compare, measures=FORMS)


@word_set("word-domain", columns=_compared(("domain",)))
def word_domain(batch: FactorBatch) -> FloatArray:
    """Synonymy in a warehouse of the figure's words with its labels, or with others'."""
    return batch.shared(_domain, "figure", words=True)


_domain = partial(_compare, measures=("domain",))


def _graded(measures: tuple[str, ...]) -> Columns:
    return tuple(
        column
        for name in measures
        for column in (
            Column(f"{name}.own", "1", 0, 1, 5),
            Column(f"{name}.margin", "1", -0.5, 0.5, 8),
            Column(f"{name}.best", "bool"),
        )
    )


def _grade(batch: FactorBatch, measures: tuple[str, ...]) -> FloatArray:
    """Similarity of the figure, how much more that is than any other thing's, and whether it is.

    Measures of meaning differ more between words than between things, so that what counts
    is which thing of the scene a word fits best. NaN where no word is known.
    """
    bodies = batch.bodies
    patterns, pattern = label_patterns(bodies.labels)
    figure_pattern = pattern[batch.figure]
    others = np.column_stack((batch.peers, batch.agent_body))
    rival = (others >= 0) & (pattern[others] != figure_pattern[:, None])
    names = [factor.get("name", ()) for factor in batch.words]
    columns = []
    for name in measures:
        score = mean_match(MEASURES[name], names, bodies.label_names, patterns)[batch.factor]
        mine = np.take_along_axis(score, figure_pattern[:, None], axis=1)[:, 0]
        theirs = np.where(rival, np.take_along_axis(score, pattern[others], axis=1), 0.0)
        margin = mine - theirs.max(axis=1)
        columns += [mine, margin, np.where(np.isnan(margin), np.nan, margin > -TIE)]
    return np.column_stack(columns)


@meaning_set("word-wordnet", columns=_graded(MEANINGS), data=wordnet_identity)
def word_wordnet(batch: FactorBatch) -> FloatArray:
    """Similarity in WordNet of the figure's words to its labels, next to others in its scene."""
    return batch.shared(_wordnet, "figure", words=True)


_wordnet = partial(_grade, measures=MEANINGS)


@meaning_set("word-tags", columns=_graded(TAGS), default=False, data=tag_table_identity)
def word_tags(batch: FactorBatch) -> FloatArray:
    """Co-occurrence as image tags of the figure's words with its labels, next to others.

    Off: the bundled table is made by hand and adds nothing to `word-domain`.
    """
    return _grade(batch, TAGS)


@meaning_set("word-vectors", columns=_graded(("vector",)), data=word_vectors_identity)
def word_vectors(batch: FactorBatch) -> FloatArray:
    """Likeness of the vectors of the figure's words and its labels, next to others in its scene."""
    return batch.shared(_vectors, "figure", words=True)


_vectors = partial(_grade, measures=("vector",))
