"""Relations between two three-dimensional boxes (section 3.3)."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np

from g3.features.batch import Boxes, FactorBatch
from g3.features.bodies import IntArray
from g3.features.registry import Column, Columns, feature_set
from g3.geometry import contains_point, corner_count, gap, intersection_area, length
from g3.groundings import FloatArray

RESTING_TOLERANCE_M = 0.35
"""How far the bottom of a thing may be from the top of what it rests on; logs are noisy."""

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


def prism_pair(figure: Boxes, landmark: Boxes) -> FloatArray:
    """Features of a figure's prism relative to a landmark's, as `PRISM_COLUMNS`.

    Lengths are divided by the mean size of the two footprints, heights by the figure's
    height, so that nothing depends on the scale.

    Returns
    -------
    FloatArray
        Shape (n, len(PRISM_COLUMNS)).
    """
    counts = np.column_stack([corner_count(prisms.corners) for prisms in (figure, landmark)])
    pairs = np.empty((len(counts), len(PRISM_COLUMNS)))
    # Those with as many corners are looked at together, without the repeated ones.
    order = np.lexsort(counts.T)
    changes = np.flatnonzero((np.diff(counts[order], axis=0) != 0).any(axis=1)) + 1
    for rows in np.split(order, changes):
        if len(rows):
            many = counts[rows[0]]
            pairs[rows] = _pairs(_some(figure, rows, many[0]), _some(landmark, rows, many[1]))
    return pairs


def _some(prisms: Boxes, rows: IntArray, corners: int) -> Boxes:
    some = Boxes(*(getattr(prisms, f.name)[rows] for f in fields(prisms)))
    return replace(some, corners=some.corners[:, :corners])


def _pairs(figure: Boxes, landmark: Boxes) -> FloatArray:
    shared = intersection_area(figure.corners, landmark.corners)
    figure_area = np.maximum(figure.area, 1e-9)
    landmark_area = np.maximum(landmark.area, 1e-9)
    scale = (size(figure) + size(landmark)) / 2
    between = gap(figure.corners, landmark.corners)
    height = np.maximum(figure.z_max - figure.z_min, 0.1)
    above = figure.z_min - landmark.z_max
    overlap = shared / figure_area
    meet_in_height = (figure.z_min <= landmark.z_max + RESTING_TOLERANCE_M) & (
        landmark.z_min <= figure.z_max + RESTING_TOLERANCE_M
    )
    return np.column_stack(
        (
            (overlap > 0.3) & (np.abs(above) < RESTING_TOLERANCE_M),
            (between < 0.1 * scale) & meet_in_height,
            contains_point(landmark.corners, figure.centre),
            between / scale,
            length(figure.centre - landmark.centre) / scale,
            overlap,
            shared / landmark_area,
            above / height,
            (figure.z_min - landmark.z_min) / height,
            np.log(figure_area / landmark_area) / np.log(10),
        )
    )


@feature_set(
    "prism-pair",
    types=("OBJECT", "PLACE"),
    roles=("figure", "landmark"),
    words=("relation",),
    columns=PRISM_COLUMNS,
    scale=0.4,
    wordless=True,
)
def figure_to_landmark(batch: FactorBatch) -> FloatArray:
    """How the figure's prism lies to the landmark's: support, contact, distance, heights."""
    return prism_pair(batch.boxes("figure"), batch.boxes("landmark"))


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
    """Which arguments the factor has, and whether figure and landmark are several things."""
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


@feature_set(
    "between",
    types=("OBJECT", "PLACE"),
    roles=("figure", "landmark"),
    words=("relation",),
    columns=(Column("straight", "1", -1, 1, 8), Column("even", "1", 0, 1, 5)),
    scale=0.3,
    wordless=True,
)
def between(batch: FactorBatch) -> FloatArray:
    """How nearly the figure lies on a line between two things of a plural landmark."""
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
    known = np.isfinite(straight[rows, best])
    return np.where(
        known[:, None], np.column_stack((straight[rows, best], ratio[rows, best])), np.nan
    )
