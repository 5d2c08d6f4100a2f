"""Agreement of geometry and words: concepts of a closed lexicon, tied over words."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache, partial

import numpy as np

from g3.features.factor_batch import FactorBatch, WordField
from g3.features.feature_registry import Column, Columns, feature_set
from g3.features.sets.prisms import between, figure_to_landmark
from g3.features.sets.ranks import RANK_COLUMNS, bearing, ranks
from g3.features.sets.reference_frames import avs_speaker, avs_start
from g3.features.sets.scene_places import PAIR
from g3.features.sets.trajectories import SHAPE_COLUMNS, own_shape
from g3.geometry.plane import BoolArray
from g3.groundings import FloatArray
from g3.language.lexicon.concepts import CONCEPTS, Concept, concepts

SIDES: tuple[Concept, ...] = ("front", "left", "back", "right")


def named(batch: FactorBatch, fields: tuple[WordField, ...]) -> BoolArray:
    """Return the concepts that the words of each row's fields name, shape (n, len(CONCEPTS))."""
    words = [tuple(word for f in fields for word in factor.get(f, ())) for factor in batch.words]
    table = np.array([_named(row) for row in words], dtype=bool).reshape(-1, len(CONCEPTS))
    return table[batch.factor]


def says(batch: FactorBatch, words: frozenset[str], field: WordField = "relation") -> BoolArray:
    """Find the rows that have any of some words in a field, shape (n,)."""
    found = [not words.isdisjoint(factor.get(field, ())) for factor in batch.words]
    return np.array(found, dtype=bool)[batch.factor]


@lru_cache(maxsize=4096)
def _named(words: tuple[str, ...]) -> tuple[bool, ...]:
    named_concepts = concepts(words)
    return tuple(concept in named_concepts for concept in CONCEPTS)


def satisfied(degrees: Mapping[Concept, FloatArray], wanted: BoolArray) -> FloatArray:
    """Degrees (n,) of the concepts that are wanted (n, len(CONCEPTS)), as `DEGREE_COLUMNS`.

    With their mean and the least of them; NaN where none is wanted.
    """
    n = len(wanted)
    table = np.full((n, len(CONCEPTS) + 2), np.nan)
    count, total, least = np.zeros(n), np.zeros(n), np.ones(n)
    for concept, degree in degrees.items():
        column = CONCEPTS.index(concept)
        if not wanted[:, column].any():
            continue
        known = wanted[:, column] & ~np.isnan(degree)
        table[known, column] = degree[known]
        count += known
        total[known] += degree[known]
        least[known] = np.minimum(least[known], degree[known])
    some = count > 0
    table[some, -2], table[some, -1] = total[some] / count[some], least[some]
    return table


DEGREE_COLUMNS: Columns = (
    *(Column(concept, "1", 0, 1, 6) for concept in CONCEPTS),
    Column("mean", "1", 0, 1, 8),
    Column("least", "1", 0, 1, 8),
)


named_set = partial(feature_set, words=(), columns=DEGREE_COLUMNS)


@named_set("named-relation", types=("OBJECT", "PLACE"), roles=("figure", "landmark"))
def named_relation(batch: FactorBatch) -> FloatArray:
    """Degree to which figure and landmark stand as the relation's words name it."""
    pair = batch.shared(figure_to_landmark, "figure", "landmark")
    start = batch.shared(avs_start, "figure", "landmark")
    speaker = batch.shared(avs_speaker, "figure", "landmark")
    sides = np.maximum(start, speaker)
    # In front of a thing is also its near side to the speaker, and behind it its far side.
    near, far = speaker[:, SIDES.index("back")], speaker[:, SIDES.index("front")]
    sides[:, 0], sides[:, 2] = np.maximum(sides[:, 0], near), np.maximum(sides[:, 2], far)
    close = np.exp(-pair[:, PAIR["gap"]])
    straight = batch.shared(between, "figure", "landmark")[:, 0]
    degrees: dict[Concept, FloatArray] = dict(zip(SIDES, sides.T, strict=True))
    degrees |= {
        "on": pair[:, PAIR["supports"]],
        "between": np.where(np.isnan(straight), close, (1 + straight) / 2),
        "near": close,
    }
    return satisfied(degrees, named(batch, ("relation",)))


@named_set("named-position", types=("OBJECT", "PLACE"), roles=("figure",))
def named_position(batch: FactorBatch) -> FloatArray:
    """Degree to which the figure lies, among its peers and from the agent, as words name it."""
    alone = batch.landmark < 0
    wanted = named(batch, ("figure",))
    if alone.any():
        wanted = wanted | (named(batch, ("figure", "relation")) & alone[:, None])
    if not wanted.any():
        return np.full((len(batch), len(DEGREE_COLUMNS)), np.nan)
    degrees = batch.shared(_positions, "figure").T
    return satisfied(dict(zip(POSITIONS, degrees, strict=True)), wanted)


POSITIONS: tuple[Concept, ...] = ("left", "right", "front", "back", "far", "near")


def _positions(batch: FactorBatch) -> FloatArray:
    """Degrees to which figures lie as `POSITIONS`, (n, len(POSITIONS))."""
    rank = {
        column.name: value
        for column, value in zip(RANK_COLUMNS, batch.once(ranks, ranks).T, strict=True)
    }
    ahead, leftward, among_ahead, among_leftward = batch.once(bearing, bearing).T

    def toward(direction: FloatArray, among: FloatArray) -> FloatArray:
        """Degree of a direction, from the agent and, where there are peers, among them."""
        mean = (direction + np.clip(among, -1, 1)) / 2
        return (1 + np.where(np.isnan(among), direction, mean)) / 2

    return np.column_stack(
        (
            np.maximum(toward(leftward, among_leftward), rank["leftward.last"]),
            np.maximum(toward(-leftward, -among_leftward), rank["leftward.first"]),
            toward(ahead, among_ahead),
            toward(-ahead, -among_ahead),
            rank["far.last"],
            rank["far.first"],
        )
    )


@named_set("named-shape", types=("EVENT", "PATH"), roles=("figure",), scale=0.2)
def named_shape(batch: FactorBatch) -> FloatArray:
    """Degree to which a trajectory turns, leads or reverses as the relation's words name it."""
    shape = {
        c.name: v for c, v in zip(SHAPE_COLUMNS, batch.shared(own_shape, "figure").T, strict=True)
    }
    turn, first = np.tanh(shape["turn"]), np.tanh(shape["first_turn"])
    lead = (shape["leftward"] + turn + first) / 3
    degrees: dict[Concept, FloatArray] = {
        "left": (1 + lead) / 2,
        "right": (1 - lead) / 2,
        "front": (1 + shape["forward"]) / 2,
        "back": np.maximum(shape["reversing"], shape["reverses_first"] / 2),
    }
    return satisfied(degrees, named(batch, ("relation",)))
