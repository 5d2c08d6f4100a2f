"""Relations between two three-dimensional boxes (section 3.3)."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

from g3.features.bodies import IntArray
from g3.features.factor_batch import Boxes, FactorBatch
from g3.features.feature_registry import Column, Columns, feature_set
from g3.geometry.plane import contains_point, gap, intersection_area, length
from g3.geometry.relations import LEVEL_M
from g3.groundings import FloatArray

relation_set = partial(
    feature_set,
    types=("OBJECT", "PLACE"),
    roles=("figure", "landmark"),
    words=("relation",),
    wordless=True,
)
"""Registers how figures and landmarks lie to each other."""


PRISM_COLUMNS: Columns = (
    Column("supports", "bool"),
    Column("contact", "bool"),
    Column("inside", "bool"),
    Column("gap", "1", 0, 4, 10),
    Column("distance", "1", 0, 5, 10),
    Column("figure_overlap", "1", 0, 1, 4),
    Column("landmark_overlap", "1", 0, 1, 4),
    Column("height_above", "1", -2, 2, 8),
    Column("height_difference", "1", -2, 2, 8),
    Column("size_ratio", "1", -2, 2, 6),
)


def size(prisms: Boxes) -> FloatArray:
    """Side in metres of a square as large as the footprint, at least 0.1; shape (n,)."""
    return np.sqrt(np.maximum(prisms.area, 0.01))


TOUCHING_M = 1e-6
"""Prisms further apart share nothing, and none has the middle of the other in it."""


def prism_pair(
    figures: Boxes, landmarks: Boxes, rows: tuple[IntArray, IntArray] | None = None
) -> FloatArray:
    """Features of n figures' prisms relative to landmarks', (n, len(PRISM_COLUMNS)).

    Lengths are divided by the mean size of the two footprints, heights by the figure's
    height, so that nothing depends on the scale. The rows say which of them each of n pairs has;
    left out, those in the same place.
    """
    rows = rows or (np.arange(len(figures.area)),) * 2
    figure, landmark = (_levels(p, row) for p, row in zip((figures, landmarks), rows, strict=True))
    between = gap(figures.corners, landmarks.corners, rows)
    scale = (figure["size"] + landmark["size"]) / 2
    offset = figures.centre.take(rows[0], axis=0) - landmarks.centre.take(rows[1], axis=0)
    height = np.maximum(figure["top"] - figure["bottom"], 0.1)
    above = figure["bottom"] - landmark["top"]
    shared, inside = np.zeros(len(between)), np.zeros(len(between), dtype=bool)
    meeting = np.flatnonzero(between < TOUCHING_M)
    first, second = (row[meeting] for row in rows)
    shared[meeting] = intersection_area(figures.corners[first], landmarks.corners[second])
    inside[meeting] = contains_point(landmarks.corners[second], figures.centre[first])
    overlap = shared / figure["area"]
    meet_in_height = (above <= LEVEL_M) & (landmark["bottom"] <= figure["top"] + LEVEL_M)
    return np.column_stack(
        (
            (overlap > 0.3) & (np.abs(above) < LEVEL_M),
            (between < 0.1 * scale) & meet_in_height,
            inside,
            between / scale,
            length(offset) / scale,
            overlap,
            shared / landmark["area"],
            above / height,
            (figure["bottom"] - landmark["bottom"]) / height,
            figure["log_area"] - landmark["log_area"],
        )
    )


def _levels(prisms: Boxes, rows: IntArray) -> Mapping[str, FloatArray]:
    """Compute the properties of single prisms that features share."""
    area = np.maximum(prisms.area, 1e-9)
    return {
        name: value.take(rows)
        for name, value in (
            ("size", size(prisms)),
            ("area", area),
            ("log_area", np.log10(area)),
            ("bottom", prisms.z_min),
            ("top", prisms.z_max),
        )
    }


@relation_set("prism-pair", columns=PRISM_COLUMNS, scale=0.4)
def figure_to_landmark(batch: FactorBatch) -> FloatArray:
    """Relation of the figure's prism to the landmark's: support, contact, distance, heights."""
    prisms = batch.all_boxes()
    return prism_pair(prisms, prisms, (batch.figure, batch.landmark))


@feature_set(
    "arguments",
    types=("OBJECT", "PLACE", "PATH", "EVENT"),
    roles=("figure",),
    words=("figure", "relation", "goal"),
    columns=(
        Column("several", "bool"),
        Column("landmark", "bool"),
        Column("landmark_several", "bool"),
        Column("theme", "bool"),
        Column("goal", "bool"),
    ),
    scale=0.5,
)
def arguments(batch: FactorBatch) -> FloatArray:
    """Presence of the factor's arguments, and plural figures and landmarks."""
    count = batch.bodies.count
    return np.column_stack(
        (
            count[batch.figure] > 1,
            batch.landmark >= 0,
            np.where(batch.landmark >= 0, count[batch.landmark] > 1, False),
            batch.theme >= 0,
            batch.goal >= 0,
        )
    ).astype(float)


@relation_set(
    "between",
    columns=(Column("straight", "1", -1, 1, 8), Column("even", "1", 0, 1, 5)),
    scale=0.3,
)
def between(batch: FactorBatch) -> FloatArray:
    """Nearness of the figure to a line between two things of a plural landmark."""
    result = np.full((len(batch), 2), np.nan)
    plural = np.flatnonzero(batch.bodies.count[batch.landmark] > 1)
    if len(plural):
        members = batch.bodies.members[batch.landmark[plural]]
        result[plural] = _between(batch.bodies.centre[batch.figure[plural]], members)
    return result


def _between(centre: FloatArray, members: FloatArray) -> FloatArray:
    arm = members - centre[:, None]
    away = np.maximum(length(arm), 1e-6)
    first, second = np.triu_indices(arm.shape[1], 1)
    cosine = (arm[:, first] * arm[:, second]).sum(axis=2) / (away[:, first] * away[:, second])
    ratio = np.minimum(away[:, first], away[:, second]) / np.maximum(
        away[:, first], away[:, second]
    )
    straight = np.where(np.isnan(cosine), -np.inf, -cosine)
    best = straight.argmax(axis=1)
    rows = np.arange(len(best))
    is_defined = np.isfinite(straight[rows, best])
    return np.where(
        is_defined[:, None], np.column_stack((straight[rows, best], ratio[rows, best])), np.nan
    )
