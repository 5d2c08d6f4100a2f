"""Attentional vector sums: how far a point lies in a direction from a landmark."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from g3.features.avs.attention import degrees
from g3.features.bodies import IntArray, Singles
from g3.geometry.plane import centroid, cross, following, length
from g3.groundings import FloatArray
from g3.short_repr import short_repr

THICKNESS, LEAST_M = 1e-3, 1e-6
"""Width of a landmark without an area, as part of its length, and at least."""

RECTANGLE = ((0, 0), (1, 0), (1, 1), (0, 1))
"""Its corners, counter-clockwise: at which end and on which side."""


@short_repr
@dataclass(frozen=True, slots=True)
class Footprints:
    """Convex landmarks with an area: n of them, of which m differ.

    Parameters
    ----------
    centre
        Centres of those that differ, shape (m, 2), in metres.
    seen
        Their corners, seen from there, shape (m, k, 2).
    row
        Index of each landmark's footprint, shape (n,).
    """

    centre: FloatArray
    seen: Singles
    row: IntArray


def footprints(corners: FloatArray, row: IntArray | None = None) -> Footprints:
    """Landmarks to measure directions from; those without an area become a little wide.

    Parameters
    ----------
    corners
        Convex, counter-clockwise, the last ones repeated where there are fewer; shape (m, k, 2),
        in metres.
    row
        Index of each landmark's footprint, shape (n,); each once if left out.
    """
    centre = centroid(corners)
    missing = max(len(RECTANGLE) - corners.shape[1], 0)
    seen = np.concatenate((corners, np.repeat(corners[:, -1:], missing, axis=1)), axis=1)
    seen -= centre[:, None]
    edge = following(seen) - seen
    side = length(edge)
    flat = np.flatnonzero(cross(seen, edge).sum(axis=1) <= 1e-12 * (side**2).sum(axis=1))
    seen[flat] = _thickened(seen[flat], edge[flat], side[flat])
    row = np.arange(len(corners)) if row is None else row
    return Footprints(centre, seen.astype(np.float32), row)


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
    """Degrees, 0 to 1, to which points lie ahead, left, behind and right of landmarks; (n, 4 k).

    Attention is centred on the point of the landmark's border that faces the direction in line with
    the figure. It falls off exponentially with the distance. The vectors from all points of the
    landmark to the figure are summed with attention as their weight; the angle between the sum and
    the direction gives the degree [1]_. The height component of the original, which orders heights
    above a horizontal top, is left out: on a map there is no gravity.

    The landmark is seen as triangles from its centre of attention to its sides. Along a ray
    from there the sum has a closed form; along each side it is looked at in three points (Gauss
    and Legendre's). Single precision is enough.

    Parameters
    ----------
    points
        Figures, shape (n, 2), in metres.
    landmarks
        The landmarks that they are seen from.
    yaw
        Headings of k frames for each of them, shape (k, n).

    References
    ----------
    .. [1] T. Regier and L. A. Carlson, "Grounding spatial language in perception: an
       empirical and computational investigation", Journal of Experimental Psychology:
       General 130(2), 2001.
    """
    frames, n = yaw.shape
    turn = yaw.astype(np.float32)
    heading = np.array((np.cos(turn), np.sin(turn)))
    seen = (landmarks.seen, landmarks.centre, landmarks.row)
    return degrees(seen, points, heading).reshape(n, 4 * frames)
