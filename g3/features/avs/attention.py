"""Attentional vector sums (:mod:`g3.features.avs.vector_sums`) over blocks of rows.

All rows of a block, all edges and all places on them are looked at in one step each. Take a ray of
length R, in units of the figure's distance. The integral of r exp(-r) along it is 1 - (1 + R)
exp(-R); that of r² exp(-r) is twice that, less R² exp(-R).
"""

from __future__ import annotations

import numpy as np

from g3.features.bodies import IntArray, Singles
from g3.geometry.plane import following
from g3.groundings import FloatArray

SLOPE_PER_DEGREE = -0.006
INTERCEPT = 1.007
"""Acceptability falls linearly with the angular deviation; the values that Regier and Carlson
(2001) fitted."""

ATTENTION_WIDTH = 1.0
"""Lambda: how fast attention falls with distance, in units of the figure's distance."""

CORNER_INSET = 0.01
"""Distance of attention from a corner, as a part of the landmark's width. At the very end of a side
that runs along the direction, noise of its corners would choose between the two."""

NEAR = 0.03
"""Nearer to the focus than this, in units of the figure's distance, attention is as at this
distance: it is all but the same there, and single precision loses its differences."""

_NODES, _SHARES = np.array(np.polynomial.legendre.leggauss(3), dtype=np.float32)
PLACES, WEIGHTS = (_NODES + 1) / 2, _SHARES / 2
"""Places on each edge of the landmark at which the sum is evaluated, and their weights."""

PRECISION_DEG = 0.01
"""Directions are rounded to this."""


BLOCK = 4096
"""Rows that are looked at together."""


def degrees(
    landmarks: tuple[Singles, FloatArray, IntArray], points: FloatArray, heading: Singles
) -> FloatArray:
    """Return the degrees to which points lie ahead, left, behind and right of landmarks.

    Parameters
    ----------
    landmarks
        Corners of those that differ, seen from their centres, shape (m, k, 2), in metres; the
        centres, (m, 2); and which of them each point is seen from, (n,).
    points
        Figures, shape (n, 2), in metres.
    heading
        Cosines and sines of the headings of the frames, shape (2, frames, n).

    Returns
    -------
    ndarray
        Shape (n, frames, 4).
    """
    seen, centre, row = landmarks
    result = np.empty((len(row), heading.shape[1], 4))
    for start in range(0, len(row), BLOCK):
        block = slice(start, start + BLOCK)
        place = row[block]
        figure = (points[block] - centre[place]).astype(np.float32)
        for frame in range(heading.shape[1]):
            cos, sin = heading[:, frame, block]
            result[block, frame, 0::2] = _along(seen[place], figure, cos, sin)
            result[block, frame, 1::2] = _along(seen[place], figure, -sin, cos)
    return result


def _along(landmark: Singles, figure: Singles, cos: Singles, sin: Singles) -> FloatArray:
    """Degrees to which figures (n, 2) lie along a direction of landmarks (n, k, 2), and against."""
    corners = _turned(landmark, cos[:, None], sin[:, None])
    ahead, aside = np.moveaxis(_turned(figure, cos, sin), -1, 0)
    low, high = corners[..., 1].min(axis=1), corners[..., 1].max(axis=1)
    inset = np.float32(CORNER_INSET) * (high - low)
    line = np.clip(aside, low + inset, high - inset)
    corners[..., 1] -= line[:, None]
    along, across = np.moveaxis(following(corners) - corners, -1, 0)
    with np.errstate(divide="ignore", invalid="ignore"):  # edges without a length
        met = corners[..., 0] - along / across * corners[..., 1]
    # Corners run counter-clockwise, so that edges that face ahead lead to the left.
    front = np.where(across > 0, met, np.inf).min(axis=1)
    back = np.where(across < 0, met, -np.inf).max(axis=1)
    return np.column_stack(
        [
            _degree(corners, focus, (ahead - focus, aside - line), sign)
            for focus, sign in ((front, 1), (back, -1))
        ]
    )


def _turned(points: Singles, cos: Singles, sin: Singles) -> Singles:
    """Return points ahead and to the left, in the last axis."""
    x, y = points[..., 0], points[..., 1]
    return np.stack((x * cos + y * sin, y * cos - x * sin), axis=-1)


def _degree(
    corners: Singles, focus: Singles, figure: tuple[Singles, Singles], sign: int
) -> FloatArray:
    """Return the degree of the direction of `sign` around a focus, shape (n,)."""
    ahead, aside = figure
    scale = 1 / (ATTENTION_WIDTH * np.maximum(np.hypot(ahead, aside), np.float32(1e-6)))
    start = corners - np.stack((focus, np.zeros_like(focus)), axis=-1)[:, None]
    edge = following(corners) - corners
    twice = start[..., 0] * edge[..., 1] - start[..., 1] * edge[..., 0]
    share = twice[..., None] * WEIGHTS
    x, y = np.moveaxis(start[:, :, None] + PLACES[:, None] * edge[:, :, None], -1, 0)
    ray = np.maximum(np.hypot(x, y) * scale[:, None, None], np.float32(NEAR))
    attention, part = np.exp(-ray), 1 / ray
    lone = (1 - (1 + ray) * attention) * part * part
    drawn = (lone + lone - attention) * part * share
    total, *mean = ((v).sum(axis=(1, 2)) for v in (lone * share, x * drawn, y * drawn))
    vector = total * ahead - mean[0], total * aside - mean[1]
    deviation = np.degrees(np.arctan2(np.abs(vector[1]), sign * vector[0]))
    rounded = np.floor(deviation / PRECISION_DEG + 0.5) * PRECISION_DEG
    degree: FloatArray = np.clip(INTERCEPT + SLOPE_PER_DEGREE * rounded.astype(float), 0.0, 1.0)
    return degree
