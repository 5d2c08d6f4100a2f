"""Features with the measures of a table.

The toolkit's own measure in metres what is near, what rests on what and what has moved. They are
of use here too (words and labels, order, directions), but three centimetres are nothing to them.
These sets are off unless ``--with`` names them, so that they change no other domain's models.
"""

from __future__ import annotations

import numpy as np

from g3.features.bodies import positions_at
from g3.features.factor_batch import FactorBatch
from g3.features.feature_registry import Column, feature_set
from g3.geometry.plane import area, centroid, gap, intersection_area, rotate
from g3.groundings import FloatArray

TOUCHING_M = 0.01


@feature_set(
    "table-pair",
    types=("OBJECT", "PLACE"),
    roles=("figure", "landmark"),
    words=("relation",),
    columns=(
        Column("rests_on", "bool"),
        Column("level", "bool"),
        Column("gap", "m", 0, 0.3, 6),
        Column("beyond", "m", -0.2, 0.2, 8),
        Column("leftward", "m", -0.2, 0.2, 8),
    ),
    default=False,
    scale=0.5,
)
def table_pair(batch: FactorBatch) -> FloatArray:
    """Position of a thing relative to another on a table, as the hand's owner sees it."""
    figure, landmark = batch.boxes("figure"), batch.boxes("landmark")
    shared = intersection_area(figure.corners, landmark.corners)
    over = shared > 0.3 * np.maximum(area(figure.corners), 1e-9)
    offset = rotate(centroid(figure.corners) - centroid(landmark.corners), -batch.agent[:, 2])
    return np.column_stack(
        (
            over & (np.abs(figure.z_min - landmark.z_max) < TOUCHING_M),
            np.abs(figure.z_min - landmark.z_min) < TOUCHING_M,
            gap(figure.corners, landmark.corners),
            offset,
        )
    )


@feature_set(
    "table-theme",
    types=("EVENT",),
    roles=("figure", "theme"),
    words=("relation", "goal"),
    columns=(
        Column("moved", "bool"),
        Column("held_at_end", "bool"),
        Column("carried", "m", 0, 0.6, 6),
        Column("nearest", "m", 0, 0.3, 6),
    ),
    default=False,
    scale=0.5,
)
def table_theme(batch: FactorBatch) -> FloatArray:
    """Nearness of the hand to a thing, and whether the hand takes it along."""
    hand = batch.bodies.xyz[batch.figure]
    theme = _during(batch)
    way = np.linalg.norm(theme - theme[:, :1], axis=2)
    apart = np.linalg.norm(theme - hand, axis=2)
    moved = way.max(axis=1) > TOUCHING_M
    together = np.abs(apart[:, -1] - apart.min(axis=1)) < TOUCHING_M
    return np.column_stack((moved, moved & together, way[:, -1], apart.min(axis=1)))


@feature_set(
    "table-goal",
    types=("EVENT",),
    roles=("figure", "theme", "goal"),
    words=("goal",),
    columns=(
        Column("end", "m", 0, 0.4, 8),
        Column("end_height", "m", -0.1, 0.1, 4),
        Column("nearer", "bool"),
    ),
    default=False,
    scale=0.5,
)
def table_goal(batch: FactorBatch) -> FloatArray:
    """End of a thing relative to its goal."""
    theme, goal = _during(batch), batch.boxes("goal")
    ends = theme[:, (0, -1), :2] - centroid(goal.corners)[:, None]
    before, after = np.linalg.norm(ends, axis=2).T
    return np.column_stack((after, theme[:, -1, 2] - goal.z_min, after < before - TOUCHING_M))


@feature_set(
    "table-path",
    types=("PATH",),
    roles=("figure", "landmark"),
    words=("relation",),
    columns=(Column("end", "m", 0, 0.4, 8), Column("nearest", "m", 0, 0.4, 8)),
    default=False,
    scale=0.5,
)
def table_path(batch: FactorBatch) -> FloatArray:
    """Nearness of the hand to a thing, and the end of its path."""
    middle = centroid(batch.boxes("landmark").corners)
    apart = np.linalg.norm(batch.bodies.xyz[batch.figure, :, :2] - middle[:, None], axis=2)
    return np.column_stack((apart[:, -1], apart.min(axis=1)))


def _during(batch: FactorBatch) -> FloatArray:
    """Return the poses of themes at the samples of events, shape (n, SAMPLES, 3).

    A thing of another table, or of the same in another log, stays where it was.
    """
    bodies, theme = batch.bodies, batch.theme
    t = bodies.t[batch.figure]
    xyz, _ = positions_at(bodies, theme, t)
    begin, end = bodies.raw_t[bodies.offsets[theme]], bodies.raw_t[bodies.offsets[theme + 1] - 1]
    apart = (end < t[:, 0]) | (begin > t[:, -1])
    result: FloatArray = np.where(apart[:, None, None], bodies.xyz[theme, :1], xyz)
    return result
