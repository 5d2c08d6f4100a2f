"""Attentional vector sums: how far a point lies in a direction from a landmark."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from g3.features.bodies import IntArray
from g3.geometry import centroid, corner_count, cross, following, length
from g3.groundings import FloatArray

Singles: TypeAlias = npt.NDArray[np.float32]

SLOPE_PER_DEGREE = -0.006
INTERCEPT = 1.007
"""Acceptability falls linearly with the angular deviation; the values that [1]_ fitted."""

ATTENTION_WIDTH = 1.0
"""Lambda: how fast attention falls with distance, in units of the figure's distance."""

CORNER_INSET = 0.01
"""How far from a corner attention stays, as part of the landmark's width: right at the end of
a side that runs along the direction, the noise of its corners would choose between the two."""

THICKNESS, LEAST_M = 1e-3, 1e-6
"""How wide a landmark without an area is, as part of its length, and at least."""

RECTANGLE = ((0, 0), (1, 0), (1, 1), (0, 1))
"""Its corners, counter-clockwise: at which end and on which side."""

NEAR = 0.03
"""Nearer to the focus than this, in units of the figure's distance, attention is as at this
distance: it is all but the same there, and single precision loses its differences."""

_NODES, _SHARES = np.array(np.polynomial.legendre.leggauss(3), dtype=np.float32)
PLACES, WEIGHTS = (_NODES + 1) / 2, _SHARES / 2
"""Where on each edge of the landmark the sum is looked at, and what it counts there."""

PRECISION_DEG = 0.01
"""Directions are rounded to this."""

BLOCK = 4096
"""Directions that are looked at together: with more, what is looked at leaves the caches."""


@dataclass(frozen=True, slots=True)
class Footprints:
    """Convex landmarks with an area: n of them, of which m differ.

    Parameters
    ----------
    centre
        Of those that differ, shape (m, 2), in metres.
    x, y
        Their corners, seen from there, shape (k, m).
    corners
        How many come before the last one is repeated, shape (m,).
    row
        Which of them each landmark is, shape (n,).
    """

    centre: FloatArray
    x: Singles
    y: Singles
    corners: npt.NDArray[np.uint8]
    row: IntArray


def footprints(corners: FloatArray, row: IntArray | None = None) -> Footprints:
    """Landmarks to measure directions from; those without an area become a little wide.

    Parameters
    ----------
    corners
        Convex, counter-clockwise, the last ones repeated where there are fewer; shape (m, k, 2),
        in metres.
    row
        Which of them each landmark is, shape (n,); each once if left out.
    """
    centre = centroid(corners)
    missing = max(len(RECTANGLE) - corners.shape[1], 0)
    seen = np.concatenate((corners, np.repeat(corners[:, -1:], missing, axis=1)), axis=1)
    seen -= centre[:, None]
    edge = following(seen) - seen
    side = length(edge)
    flat = np.flatnonzero(cross(seen, edge).sum(axis=1) <= 1e-12 * (side**2).sum(axis=1))
    seen[flat] = _thickened(seen[flat], edge[flat], side[flat])
    x, y = np.ascontiguousarray(seen.T, dtype=np.float32)
    return Footprints(
        centre, x, y, corner_count(seen), np.arange(len(corners)) if row is None else row
    )


def _thickened(corners: FloatArray, edge: FloatArray, side: FloatArray) -> FloatArray:
    """Rectangles around lines and points, with as many corners (m, k, 2)."""
    rows = np.arange(len(corners))
    longest = side.argmax(axis=1)
    span = side[rows, longest]
    along = np.where(span[:, None] > 0, edge[rows, longest], [1.0, 0.0])
    along /= length(along)[:, None]
    across = np.column_stack((-along[:, 1], along[:, 0]))
    reach = np.einsum("mkc,mc->mk", corners, along)
    low, high = reach.min(axis=1), reach.max(axis=1)
    half = (THICKNESS * (high - low) + LEAST_M) / 2
    ends, sides = ((low - half), (high + half)), (-half, half)
    around = [(ends[i], sides[j]) for i, j in RECTANGLE]
    around += [around[-1]] * (corners.shape[1] - len(around))
    return np.stack([a[:, None] * along + s[:, None] * across for a, s in around], axis=1)


def avs_directions(points: FloatArray, landmarks: Footprints, yaw: FloatArray) -> FloatArray:
    """Degrees, from 0 to 1, to which points lie ahead, left, behind and right of landmarks.

    Attention is centred on the point of the landmark's border that faces the direction
    in line with the figure, and falls off exponentially with the distance from it. The
    vectors from all points of the landmark to the figure are summed with attention as
    their weight; the angle between the sum and the direction gives the degree [1]_. The
    height component of the original, which orders heights above a horizontal top, is
    left out: on a map there is no gravity.

    The landmark is seen as triangles from its centre of attention to its sides. Along a ray
    from there the sum has a closed form; along each side it is looked at in three points (Gauss
    and Legendre's). Single precision is enough.

    Parameters
    ----------
    points
        Figures, shape (n, 2), in metres.
    landmarks
        What they are seen from.
    yaw
        Where k frames head for each of them, shape (k, n).

    Returns
    -------
    FloatArray
        Shape (n, 4 k).

    References
    ----------
    .. [1] T. Regier and L. A. Carlson, "Grounding spatial language in perception: an
       empirical and computational investigation", Journal of Experimental Psychology:
       General 130(2), 2001.
    """
    frames, n = yaw.shape
    # To the left is ahead for who has turned by a quarter.
    heading = np.concatenate((yaw, yaw + np.pi / 2)).astype(np.float32).reshape(-1)
    row, figure = np.tile(landmarks.row, 2 * frames), np.tile(points, (2 * frames, 1))
    angle = np.empty((2, len(row)), dtype=np.float32)
    # Those with as many corners are looked at together.
    order = np.argsort(landmarks.corners[row], kind="stable")
    # To ask the system for so much memory again and again takes as long as to fill it.
    most = len(PLACES) * int(landmarks.corners.max(initial=0))
    room = np.empty((6, 2, most, min(BLOCK, len(row))), dtype=np.float32)
    for start in range(0, len(row), BLOCK):
        some = order[start : start + BLOCK]
        place = row[some]
        corners = int(landmarks.corners[place[-1]])
        x, y = (c[:corners].take(place, axis=1) for c in (landmarks.x, landmarks.y))
        offset = (figure[some] - landmarks.centre[place]).astype(np.float32)
        cos, sin = np.cos(heading[some]), np.sin(heading[some])
        angle[:, some] = _deviations(
            _turned(x, y, cos, sin),
            _turned(offset[:, 0], offset[:, 1], cos, sin),
            room[:, :, : len(PLACES) * corners, : len(some)],
        )
    steps = np.rint(np.degrees(angle) / np.float32(PRECISION_DEG)).astype(float)
    degrees = np.clip(INTERCEPT + SLOPE_PER_DEGREE * PRECISION_DEG * steps, 0.0, 1.0)
    by_frame: FloatArray = degrees.reshape(2, 2, frames, n).transpose(3, 2, 0, 1)
    return by_frame.reshape(n, 4 * frames)


def _turned(x: Singles, y: Singles, cos: Singles, sin: Singles) -> tuple[Singles, Singles]:
    """Points as seen by who heads in a direction: how far ahead and to the left."""
    return x * cos + y * sin, y * cos - x * sin


def _deviations(
    corners: tuple[Singles, Singles], figure: tuple[Singles, Singles], room: Singles
) -> Singles:
    """Angular deviations (2, n) of figures from straight ahead and from straight back.

    Of figures and of landmarks with corners (k, n), how far ahead and to the left they are; and
    room (6, 2, p, n) for points of the border.
    """
    (ahead, side), (x, y) = corners, figure
    low, high = side.min(axis=0), side.max(axis=0)
    inset = np.float32(CORNER_INSET) * (high - low)
    in_line = np.minimum(np.maximum(y, low + inset), high - inset)
    side, y = side - in_line, y - in_line
    ahead_edge, side_edge = (np.concatenate((c[1:], c[:1])) - c for c in (ahead, side))
    # Corners run counter-clockwise, so that edges that face ahead lead to the left.
    with np.errstate(divide="ignore", invalid="ignore"):
        border = ahead - ahead_edge / side_edge * side
    beyond = np.copysign(np.float32(np.inf), -side_edge)
    # Between corners that are the same there is no border: NaN, which fmin and fmax skip.
    front = np.fmin.reduce(np.maximum(border, beyond), axis=0)
    back = np.fmax.reduce(np.minimum(border, beyond), axis=0)
    focus = np.stack((front, back))
    figure_ahead = x - focus
    distance = np.sqrt(figure_ahead * figure_ahead + y * y)
    rate = 1 / (np.float32(ATTENTION_WIDTH) * np.maximum(distance, np.float32(1e-6)))
    from_focus = ahead - focus[:, None]
    x_seen, (y_seen, y_square), share = room[:3]
    for i, (place, weight) in enumerate(zip(PLACES, WEIGHTS, strict=True)):
        part = slice(i * len(ahead), (i + 1) * len(ahead))
        np.add(from_focus, place * ahead_edge, out=x_seen[:, part])
        np.add(side, place * side_edge, out=y_seen[part])
        area = np.subtract(from_focus * side_edge, side * ahead_edge, out=share[:, part])
        area *= weight
    np.multiply(y_seen, y_seen, out=y_square)
    attended, drawn_ahead, drawn_aside = _attend(room, rate)
    total_ahead = attended * figure_ahead - drawn_ahead
    total_ahead[1] *= -1
    angle: Singles = np.arctan2(np.abs(attended * y - drawn_aside), total_ahead)
    return angle


def _attend(room: Singles, rate: Singles) -> tuple[Singles, Singles, Singles]:
    """Sums over landmarks' points of attention and of attention times point, shape (2, n) each.

    In the room are points x, y and y² (2, p, n) of the border seen from two foci, with their share
    in the area, and space. Attention falls at a rate (2, n). Along a ray of length R, in units of
    it, the integrals of r exp(-r) and r² exp(-r) are 1 - (1 + R) exp(-R), and twice that less
    R² exp(-R).
    """
    x, (y, y_square), share, ray, attention, lone = room
    np.multiply(x, x, out=ray)
    ray += y_square
    np.sqrt(ray, out=ray)
    ray *= rate[:, None]
    np.maximum(ray, np.float32(NEAR), out=ray)
    np.exp(np.negative(ray, out=attention), out=attention)
    np.add(ray, np.float32(1), out=lone)
    lone *= attention
    np.subtract(np.float32(1), lone, out=lone)
    lone /= ray
    lone /= ray
    drawn = np.subtract(lone, attention, out=attention)
    drawn += lone
    drawn /= ray
    lone *= share
    drawn *= share
    x *= drawn
    drawn *= y
    return lone.sum(axis=1), x.sum(axis=1), drawn.sum(axis=1)
