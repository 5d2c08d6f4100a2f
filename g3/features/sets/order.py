"""Position of a thing among those that its words could mean: "second from the left".

"The rightmost pallet" stands among all pallets, "the rightmost tire pallet" among those of tires:
the words decide what the figure competes with.
"""

from __future__ import annotations

import numpy as np

from g3.features.factor_batch import FactorBatch, WordField
from g3.features.feature_registry import Column, feature_set
from g3.features.sets.named import named
from g3.features.sets.ranks import SAME_PLACE_M, is_robot, local_centres, peer_centres
from g3.geometry.plane import BoolArray, length
from g3.groundings import FloatArray
from g3.language.lexicon.concepts import CONCEPTS, Concept
from g3.language.lexicon.field_words import normalise
from g3.language.lexicon.tables import COUNTS
from g3.language.similarity.word_similarity import MEASURES

DIRECTIONS: tuple[Concept, ...] = ("left", "right", "front", "back", "near", "far")

SYNONYM = 0.5
"""Fit of a synonym; a label itself fits with 1."""
_ORDINALS = {normalise(word): number for word, number in COUNTS["ordinals"].items()}


def is_ordinal(word: str) -> bool:
    """Check that a normalised word is an ordinal: "second", "3rd"."""
    return word in _ORDINALS


def all_ordinals(batch: FactorBatch, field: WordField) -> list[frozenset[int]]:
    """Return the ordinals in the words of a field of each factor: "first and second"."""
    return [
        frozenset(_ORDINALS[w] for w in factor.get(field, ()) if w in _ORDINALS)
        for factor in batch.words
    ]


def ordinals(batch: FactorBatch, fields: tuple[WordField, ...]) -> FloatArray:
    """Return the ordinal in the words of each row's fields, 0 for none; shape (n,)."""
    numbers = [
        next((_ORDINALS[w] for f in fields for w in factor.get(f, ()) if w in _ORDINALS), 0)
        for factor in batch.words
    ]
    return np.array(numbers, dtype=float)[batch.factor]


@feature_set(
    "named-order",
    types=("OBJECT",),
    roles=("figure",),
    words=(),
    columns=(
        Column("beaten", "1", 0, 1, 6),
        Column("middle", "1", 0, 1, 4),
        Column("ordinal", "1", 0, 1, 4),
    ),
    scale=0.7,
)
def named_order(batch: FactorBatch) -> FloatArray:
    """Place that words name ("left-most", "second from the right") among what they could mean."""
    wanted = named(batch, ("figure",)) | (
        named(batch, ("figure", "relation")) & (batch.landmark < 0)[:, None]
    )
    direction = wanted[:, [CONCEPTS.index(c) for c in DIRECTIONS]]
    direction[:, DIRECTIONS.index("far")] |= wanted[:, CONCEPTS.index("last")]
    between, from_side = (wanted[:, CONCEPTS.index(c)] for c in ("between", "from"))
    number = ordinals(batch, ("figure",))
    if not (direction.any() or between.any() or number.any()):
        return np.full((len(batch), 3), np.nan)
    ahead, beaten = np.split(batch.shared(standing, "figure", words=True), 2, axis=1)
    middle = 1 - np.abs(2 * beaten[:, 0] - 1)
    table = np.column_stack(
        (
            _mean(beaten, direction),
            np.where(between, middle, np.nan),
            _ordinal(number, ahead, direction, from_side),
        )
    )
    table[is_robot(batch) | (batch.bodies.count[batch.figure] > 1)] = np.nan
    return table


def standing(batch: FactorBatch) -> FloatArray:
    """Count rivals further in each direction, and the share of those less far.

    Shape (n, 2 directions); the parts are NaN where there is no rival.
    """
    rival = rivals(batch)
    figure_extents = extents(local_centres(batch, batch.figure))
    others = extents(batch.once(peer_centres, peer_centres))
    ahead, level = np.empty(figure_extents.shape), np.empty(figure_extents.shape)
    for i in range(len(DIRECTIONS)):
        other, mine = others[..., i], figure_extents[:, None, i]
        ahead[:, i] = np.count_nonzero(rival & (other > mine + SAME_PLACE_M), axis=1)
        level[:, i] = np.count_nonzero(rival & (np.abs(other - mine) <= SAME_PLACE_M), axis=1)
    count = np.count_nonzero(rival, axis=1)[:, None]
    beaten = np.where(count > 0, 1 - (ahead + level / 2) / np.maximum(count, 1), np.nan)
    return np.hstack((ahead, beaten))


def fits(batch: FactorBatch) -> FloatArray:
    """Count the words of each factor's figure that fit a label of each body, (factors, bodies)."""
    vocabulary = sorted({word for factor in batch.words for word in factor.get("name", ())})
    row = {word: i for i, word in enumerate(vocabulary)}
    names = batch.bodies.label_names
    forms, synonyms = (MEASURES[name](vocabulary, names) for name in ("lemma", "domain"))
    fit = np.maximum(forms, SYNONYM * synonyms)
    word_fits = (fit[:, None] * batch.bodies.labels).max(axis=2, initial=0.0)
    return np.array(
        [word_fits[[row[w] for w in factor.get("name", ())]].sum(axis=0) for factor in batch.words],
        dtype=float,
    ).reshape(len(batch.words), len(batch.bodies.labels))


def rivals(batch: FactorBatch) -> BoolArray:
    """Return the peers whose labels fit the figure's words as well as its own; (n, p)."""
    score = fits(batch)
    figure_score = score[batch.factor, batch.figure]
    result: BoolArray = (
        (batch.peers >= 0)
        & (batch.peers != batch.figure[:, None])
        & (score[batch.factor[:, None], batch.peers] >= figure_score[:, None])
    )
    return result


def extents(local: FloatArray) -> FloatArray:
    """Return extents of centres (..., 2) from the agent in each direction, (..., directions)."""
    forward, leftward = local[..., 0], local[..., 1]
    away = length(local)
    return np.stack((leftward, -leftward, forward, -forward, -away, away), axis=-1)


def _mean(degrees: FloatArray, wanted: BoolArray) -> FloatArray:
    counts = wanted & ~np.isnan(degrees)
    total = np.where(counts, degrees, 0.0).sum(axis=1)
    return np.where(counts.any(axis=1), total / np.maximum(counts.sum(axis=1), 1), np.nan)


def _ordinal(
    number: FloatArray, ahead: FloatArray, side: BoolArray, from_side: BoolArray
) -> FloatArray:
    """1 for the place that the words count to, less the further off; NaN where none is.

    "The second from the left" is counted from the left; "the second on the left" from there or
    by distance, whichever fits better; "the second" by distance.
    """
    counted = side.copy()
    counted[:, DIRECTIONS.index("near")] |= ~(from_side & side.any(axis=1))
    off = np.where(counted, np.abs(ahead - (number[:, None] - 1)), np.inf).min(axis=1)
    return np.where(number > 0, 1 / (1 + off), np.nan)
