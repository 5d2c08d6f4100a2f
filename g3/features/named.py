"""Whether the geometry is as the words say: concepts of a closed lexicon, tied over words."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from g3.features.batch import FactorBatch, WordField
from g3.features.frames import avs_speaker, avs_start
from g3.features.prisms import between, figure_to_landmark
from g3.features.ranks import RANK_COLUMNS, bearing, ranks
from g3.features.registry import Column, Columns, feature_set
from g3.features.scene import PAIR
from g3.features.trajectories import SHAPE_COLUMNS, own_shape
from g3.groundings import FloatArray
from g3.language.concepts import CONCEPTS, Concept, concepts

SIDES: tuple[Concept, ...] = ("front", "left", "back", "right")


def named(batch: FactorBatch, fields: tuple[WordField, ...]) -> npt.NDArray[np.bool_]:
    """Which concepts the words of each row's fields name, shape (n, len(CONCEPTS))."""
    words = [tuple(word for f in fields for word in factor.get(f, ())) for factor in batch.words]
    table = np.array([_named(row) for row in words], dtype=bool).reshape(-1, len(CONCEPTS))
    return table[batch.factor]


@lru_cache(maxsize=4096)
def _named(words: tuple[str, ...]) -> tuple[bool, ...]:
    found = concepts(words)
    return tuple(concept in found for concept in CONCEPTS)


def satisfied(degrees: FloatArray, wanted: npt.NDArray[np.bool_]) -> FloatArray:
    """Mean and least of the wanted degrees, NaN where none is wanted; shape (n, 2)."""
    known = wanted & ~np.isnan(degrees)
    count = known.sum(axis=1)
    total = np.where(known, degrees, 0.0).sum(axis=1)
    least = np.where(known, degrees, np.inf).min(axis=1)
    return np.where(
        (count > 0)[:, None],
        np.column_stack((total / np.maximum(count, 1), np.minimum(least, 1.0))),
        np.nan,
    )


DEGREE_COLUMNS: Columns = (
    *(Column(concept, "1", 0, 1, 6) for concept in CONCEPTS),
    Column("mean", "1", 0, 1, 8),
    Column("least", "1", 0, 1, 8),
)


@feature_set(
    "named-relation",
    types=("OBJECT", "PLACE"),
    roles=("figure", "landmark"),
    words=(),
    columns=DEGREE_COLUMNS,
)
def named_relation(batch: FactorBatch) -> FloatArray:
    """Degree to which figure and landmark stand as the relation's words name it."""
    pair = batch.shared(figure_to_landmark, "figure", "landmark")
    start = batch.shared(avs_start, "figure", "landmark")
    speaker = batch.shared(avs_speaker, "figure", "landmark")
    sides = np.maximum(start, speaker)
    # In front of a thing is also its near side to the speaker, and behind it its far side.
    near, far = speaker[:, SIDES.index("back")], speaker[:, SIDES.index("front")]
    sides[:, 0], sides[:, 2] = np.maximum(sides[:, 0], near), np.maximum(sides[:, 2], far)
    degrees = np.full((len(batch), len(CONCEPTS)), np.nan)

    def put(concept: Concept, value: FloatArray) -> None:
        degrees[:, CONCEPTS.index(concept)] = value

    for i, side in enumerate(SIDES):
        put(side, sides[:, i])
    put("on", pair[:, PAIR["supports"]])
    straight = batch.shared(between, "figure", "landmark")[:, 0]
    put("between", np.where(np.isnan(straight), np.exp(-pair[:, PAIR["gap"]]), (1 + straight) / 2))
    put("near", np.exp(-pair[:, PAIR["gap"]]))
    wanted = named(batch, ("relation",))
    return np.column_stack((np.where(wanted, degrees, np.nan), satisfied(degrees, wanted)))


@feature_set(
    "named-position",
    types=("OBJECT", "PLACE"),
    roles=("figure",),
    words=(),
    columns=DEGREE_COLUMNS,
)
def named_position(batch: FactorBatch) -> FloatArray:
    """Degree to which the figure lies, among its peers and from the agent, as words name it."""
    rank = {
        column.name: value
        for column, value in zip(RANK_COLUMNS, batch.shared(ranks, "figure").T, strict=True)
    }
    ahead, leftward, among_ahead, among_leftward = batch.shared(bearing, "figure").T
    degrees = np.full((len(batch), len(CONCEPTS)), np.nan)

    def put(concept: Concept, degree: FloatArray) -> None:
        degrees[:, CONCEPTS.index(concept)] = degree

    def toward(direction: FloatArray, among: FloatArray) -> FloatArray:
        """Degree of a direction, from the agent and, where there are peers, among them."""
        mean = (direction + np.clip(among, -1, 1)) / 2
        return (1 + np.where(np.isnan(among), direction, mean)) / 2

    put("left", np.maximum(toward(leftward, among_leftward), rank["leftward.last"]))
    put("right", np.maximum(toward(-leftward, -among_leftward), rank["leftward.first"]))
    put("front", toward(ahead, among_ahead))
    put("back", toward(-ahead, -among_ahead))
    put("far", rank["far.last"])
    put("near", rank["far.first"])
    alone = batch.landmark < 0
    fields: tuple[WordField, ...] = ("figure", "relation")
    wanted = named(batch, ("figure",)) | (named(batch, fields) & alone[:, None])
    return np.column_stack((np.where(wanted, degrees, np.nan), satisfied(degrees, wanted)))


@feature_set(
    "named-shape",
    types=("EVENT", "PATH"),
    roles=("figure",),
    words=(),
    columns=DEGREE_COLUMNS,
    scale=0.2,
)
def named_shape(batch: FactorBatch) -> FloatArray:
    """Degree to which a trajectory turns, leads or reverses as the relation's words name it."""
    shape = {
        c.name: v for c, v in zip(SHAPE_COLUMNS, batch.shared(own_shape, "figure").T, strict=True)
    }
    degrees = np.full((len(batch), len(CONCEPTS)), np.nan)
    turn = np.tanh(shape["turn"])
    first = np.tanh(shape["first_turn"])
    for concept, sign in (("left", 1), ("right", -1)):
        lead = sign * (shape["leftward"] + turn + first) / 3
        degrees[:, CONCEPTS.index(concept)] = (1 + lead) / 2
    degrees[:, CONCEPTS.index("front")] = (1 + shape["forward"]) / 2
    degrees[:, CONCEPTS.index("back")] = np.maximum(shape["reversing"], shape["reverses_first"] / 2)
    wanted = named(batch, ("relation",))
    return np.column_stack((np.where(wanted, degrees, np.nan), satisfied(degrees, wanted)))
