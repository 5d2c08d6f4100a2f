"""Where a robot can drive and turn."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt
from scipy.ndimage import distance_transform_edt, label

from corpus_tools.world.scenarios.boxes import Box
from corpus_tools.world.scenarios.scenario import Bounds
from g3.geometry.plane import rotate
from g3.groundings import FloatArray

CELL_M = 0.2
TURNING_M = 2.0
"""The robot with a load turns on the spot within this distance of its position."""

_EIGHT = np.ones((3, 3), dtype=int)

Mask = npt.NDArray[np.bool_]


def connected(points: FloatArray, boxes: Iterable[Box], bounds: Bounds) -> bool:
    """Whether a robot gets from each point to each other one, with room to turn all the way.

    `points` are positions, shape (n, 2), in metres; `boxes` are in the way, at any height; the
    robot's position stays in `bounds`.
    """
    low, high = (np.array([bounds.x[i], bounds.y[i]]) for i in (0, 1))
    if (points < low).any() or (points > high).any():
        return False
    cells = np.ceil((high - low) / CELL_M).astype(int) + 1
    taken: Mask = np.zeros(cells, dtype=bool)
    for box in boxes:
        _fill(taken, box, low)
    # A cell counts as taken if its middle is, which is up to half a diagonal off.
    room = distance_transform_edt(~taken) * CELL_M if taken.any() else np.full(cells, np.inf)
    regions, _ = label(room >= TURNING_M + CELL_M * np.sqrt(0.5), structure=_EIGHT)
    at = np.rint((points - low) / CELL_M).astype(int)
    found = regions[at[:, 0], at[:, 1]]
    return bool(found[0] > 0 and (found == found[0]).all())


def _fill(taken: Mask, box: Box, low: FloatArray) -> None:
    corners = (box.footprint - low) / CELL_M
    first = np.maximum(np.floor(corners.min(axis=0)).astype(int), 0)
    last = np.minimum(np.ceil(corners.max(axis=0)).astype(int) + 1, taken.shape)
    if (first >= last).any():
        return
    x, y = np.meshgrid(*(np.arange(a, b) for a, b in zip(first, last, strict=True)), indexing="ij")
    away = low + CELL_M * np.stack((x, y), axis=-1) - box.middle
    inside = np.abs(rotate(away, np.full(away.shape[:-1], -box.pose[2]))) <= np.array(box.size) / 2
    taken[first[0] : last[0], first[1] : last[1]] |= inside.all(axis=-1)
