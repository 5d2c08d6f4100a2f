"""Directions in a frame of reference: "left of", "in front of", "behind" (section 3.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import numpy.typing as npt

from g3.features.batch import FactorBatch, Role
from g3.features.bodies import IntArray
from g3.features.registry import Column, Columns, feature_set
from g3.geometry import centroid, cross, following, length
from g3.groundings import FloatArray

DIRECTIONS = ("front", "left", "back", "right")
"""The four cardinal directions of a frame, a quarter turn counter-clockwise each."""

SLOPE_PER_DEGREE = -0.006
INTERCEPT = 1.007
"""Acceptability falls linearly with the angular deviation; the values that [1]_ fitted."""

ATTENTION_WIDTH = 1.0
"""Lambda: how fast attention falls with distance, in units of the figure's distance."""

CORNER_INSET = 0.01
"""How far from a corner attention stays, as part of the landmark's width: right at the end of
a side that runs along the direction, the noise of its corners would choose between the two."""

GRID = (np.arange(5) + 0.5) / 5

BLOCK = 512
"""Rows whose points are looked at together: so many stay in a core's cache."""


@dataclass(frozen=True, slots=True)
class Grid:
    """Points spread over the footprints of n landmarks, of which m differ.

    Parameters
    ----------
    corners
        Of the m footprints, shape (2, k, m), in metres.
    centre
        Of each, shape (m, 2).
    x, y
        The points, seen from there, shape (m, g); single precision is enough for a mean.
    share
        Of the area that each point stands for, shape (m, g).
    used
        How many points have a share, shape (m,); the others come last.
    row
        Which footprint each landmark has, shape (n,).
    """

    corners: FloatArray
    centre: FloatArray
    x: npt.NDArray[np.float32]
    y: npt.NDArray[np.float32]
    share: npt.NDArray[np.float32]
    used: IntArray
    row: IntArray


def attention_vector_sums(points: FloatArray, landmarks: Grid, direction: FloatArray) -> FloatArray:
    """Degrees to which a point lies in a direction from a landmark and against it, from 0 to 1.

    Attention is centred on the point of the landmark's border that faces the direction
    in line with the figure, and falls off exponentially with the distance from it. The
    vectors from all points of the landmark to the figure are summed with attention as
    their weight; the angle between the sum and the direction gives the degree [1]_. The
    height component of the original, which orders heights above a horizontal top, is
    left out: on a map there is no gravity.

    Parameters
    ----------
    points
        Figures, shape (n, 2), in metres.
    landmarks
        Points spread over n convex footprints.
    direction
        Unit vectors, shape (n, 2).

    Returns
    -------
    FloatArray
        Shape (n, 2).

    References
    ----------
    .. [1] T. Regier and L. A. Carlson, "Grounding spatial language in perception: an
       empirical and computational investigation", Journal of Experimental Psychology:
       General 130(2), 2001.
    """
    centre = landmarks.centre[landmarks.row]
    foci = _foci(points, landmarks, direction)
    rates = [-1 / (ATTENTION_WIDTH * np.maximum(length(points - focus), 1e-6)) for focus in foci]
    attended = _attend(landmarks, [focus - centre for focus in foci], rates)
    totals = [(points - centre) * total[:, None] - drawn for total, drawn in attended]
    deviation = np.column_stack(
        [
            np.arctan2(np.abs(cross(direction, total)), sense * _dot(total, direction))
            for total, sense in zip(totals, (1, -1), strict=True)
        ]
    )
    degrees: FloatArray = np.clip(INTERCEPT + SLOPE_PER_DEGREE * np.degrees(deviation), 0.0, 1.0)
    return degrees


def _attend(
    grid: Grid, foci: Sequence[FloatArray], rates: Sequence[FloatArray]
) -> list[tuple[FloatArray, FloatArray]]:
    """For each focus (n, 2), sums over landmarks' points of attention and of attention times point.

    Attention falls at a rate (n,) with the distance from the focus; it is 1 at the nearest point.
    """
    sums = [(np.empty(len(focus)), np.empty_like(focus)) for focus in foci]
    single = [
        (f.T.astype(np.float32), r.astype(np.float32)) for f, r in zip(foci, rates, strict=True)
    ]
    # Rows that look at as many points are looked at together.
    by_use = np.argsort(grid.used[grid.row], kind="stable")
    for start in range(0, len(by_use), BLOCK):
        rows = by_use[start : start + BLOCK]
        landmark = grid.row[rows]
        points = grid.used[landmark[-1]]
        x, y, share = (table[landmark, :points] for table in (grid.x, grid.y, grid.share))
        for (attended, drawn), ((fx, fy), rate) in zip(sums, single, strict=True):
            attention, dy = x - fx[rows, None], y - fy[rows, None]
            attention *= attention
            dy *= dy
            attention += dy
            np.sqrt(attention, out=attention)
            # The sums' directions don't depend on it, and near the border nothing underflows.
            attention -= attention.min(axis=1, keepdims=True)
            attention *= rate[rows, None]
            np.exp(attention, out=attention)
            attention *= share
            attended[rows] = attention.sum(axis=1)
            drawn[rows, 0] = np.einsum("ng,ng->n", attention, x)
            drawn[rows, 1] = np.einsum("ng,ng->n", attention, y)
    return sums


def _foci(points: FloatArray, grid: Grid, direction: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The border points furthest in a direction and against it, as nearly in line as can be."""
    x, y = grid.corners[:, :, grid.row]
    dx, dy = np.ascontiguousarray(direction.T)
    ahead, side = x * dx + y * dy, y * dx - x * dy
    low, high = side.min(axis=0), side.max(axis=0)
    inset = CORNER_INSET * (high - low)
    target = np.clip(points[:, 1] * dx - points[:, 0] * dy, low + inset, high - inset)
    span = np.roll(side, -1, axis=0) - side
    flat = np.abs(span) < 1e-9
    ratio = (target - side) / np.where(flat, 1.0, span)
    off_edge = (ratio < -1e-9) | (ratio > 1 + 1e-9) | flat
    height = ahead + ratio * (np.roll(ahead, -1, axis=0) - ahead)
    height[off_edge] = np.nan
    front, back = np.fmax.reduce(height, axis=0), np.fmin.reduce(height, axis=0)
    nowhere = np.isnan(front)
    front = np.where(nowhere, ahead.max(axis=0), front)
    back = np.where(nowhere, ahead.min(axis=0), back)
    first, second = (
        np.stack((best * dx - target * dy, best * dy + target * dx), axis=1)
        for best in (front, back)
    )
    return first, second


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    product: FloatArray = a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1]
    return product


def footprint_grid(footprints: FloatArray, row: IntArray | None = None) -> Grid:
    """Points on rays from the centre of each footprint to points along its border.

    A repeated corner stands for no area; where there is no area at all, shares go by the
    border's length.

    Parameters
    ----------
    footprints
        Convex, shape (m, k, 2), in metres.
    row
        Which of them each landmark has, shape (n,); each once if left out.
    """
    m = len(footprints)
    row = np.arange(m) if row is None else row
    centre = centroid(footprints)
    arm, edge = footprints - centre[:, None], following(footprints) - footprints
    triangle, side = cross(arm, edge), length(edge)
    flat = triangle.sum(axis=1) <= 1e-12 * (side**2).sum(axis=1)
    share = np.where(flat[:, None], side, np.maximum(triangle, 0.0))
    share[:, 0] += 1e-12 * flat
    # Edges without a share come last, where they need not be looked at.
    order = np.argsort(share <= 0, axis=1, kind="stable")
    arm, edge = (np.take_along_axis(v, order[..., None], axis=1) for v in (arm, edge))
    share = np.take_along_axis(share, order, axis=1)
    border = arm[:, :, None] + GRID[:, None] * edge[:, :, None]
    points = GRID[:, None, None] * border[:, :, None]
    shares = np.broadcast_to((share[..., None] * GRID)[..., None], points.shape[:-1])
    x, y, weight = (
        v.reshape(m, -1).astype(np.float32) for v in (points[..., 0], points[..., 1], shares)
    )
    used = (share > 0).sum(axis=1) * len(GRID) ** 2
    return Grid(np.ascontiguousarray(footprints.T), centre, x, y, weight, used, row)


def avs_directions(points: FloatArray, landmarks: Grid, yaw: FloatArray) -> FloatArray:
    """AVS for the four directions of k frames with headings yaw (k, n); shape (n, 4 k)."""
    k, n = yaw.shape
    x, y = np.cos(yaw), np.sin(yaw)
    axes = np.stack(((x, -y), (y, x)), axis=-1).reshape(2 * k * n, 2)
    everywhere = replace(landmarks, row=np.tile(landmarks.row, 2 * k))
    both_ways = attention_vector_sums(np.tile(points, (2 * k, 1)), everywhere, axes)
    by_frame: FloatArray = both_ways.reshape(2, k, n, 2).transpose(2, 1, 3, 0)
    degrees: FloatArray = by_frame.reshape(n, len(DIRECTIONS) * k)
    return degrees


def speaker_yaw(agent: FloatArray, centre: FloatArray) -> FloatArray:
    """Heading of the line of sight from the agent's start (n, 3) to landmarks' centres; (n,)."""
    sight = centre - agent[:, :2]
    return np.arctan2(sight[:, 1], sight[:, 0])


LEAN_RAD = 1e-4
"""A side that lies straight across the agent's heading counts as pointing to its left."""


def intrinsic_yaw(landmarks: FloatArray, agent: FloatArray) -> FloatArray:
    """Heading of a landmark's longest side, of the two senses the one more along the agent's.

    Pallets and trailers have no front in the semantic map, so the sense is taken from
    how the agent meets them. Of sides as long as each other, as a square's, the one more
    along the agent's heading counts, not the one that the noise of its corners makes longer.
    """
    edges = following(landmarks) - landmarks
    side = length(edges)
    long = side >= 0.999 * side.max(axis=1, keepdims=True)
    yaw = np.arctan2(edges[..., 1], edges[..., 0])
    along = np.cos(yaw - agent[:, 2:] - LEAN_RAD)
    rows = np.arange(len(edges))
    best = np.where(long, np.abs(along), -1.0).argmax(axis=1)
    sense: FloatArray = np.where(along[rows, best] < 0, np.pi, 0.0)
    heading: FloatArray = yaw[rows, best] + sense
    return heading


def frame_columns(frame: str) -> Columns:
    """Columns of AVS in one frame."""
    return tuple(Column(f"{frame}.{d}", "1", 0, 1, 6) for d in DIRECTIONS)


def grid_of(batch: FactorBatch, role: Role) -> Grid:
    """Points spread over the bodies in a role, for all sets that need them."""
    return batch.once(("grid", role), partial(_grid, role=role))


def _grid(batch: FactorBatch, role: Role) -> Grid:
    used, row = np.unique(batch.role(role), return_inverse=True)
    return footprint_grid(batch.bodies.corners[used], row.reshape(-1))


@feature_set(
    "avs-start",
    types=("OBJECT", "PLACE"),
    roles=("figure", "landmark"),
    words=("relation",),
    columns=frame_columns("start"),
    scale=0.2,
    wordless=True,
)
def avs_start(batch: FactorBatch) -> FloatArray:
    """AVS of figure and landmark in the frame of the agent's starting orientation."""
    landmarks = grid_of(batch, "landmark")
    return avs_directions(batch.boxes("figure").centre, landmarks, batch.agent[None, :, 2])


@feature_set(
    "avs-speaker",
    types=("OBJECT", "PLACE"),
    roles=("figure", "landmark"),
    words=("relation",),
    columns=frame_columns("speaker"),
    scale=0.3,
    wordless=True,
)
def avs_speaker(batch: FactorBatch) -> FloatArray:
    """AVS in the frame of the line of sight from the agent's start to the landmark."""
    yaw = speaker_yaw(batch.agent, batch.boxes("landmark").centre)
    return avs_directions(batch.boxes("figure").centre, grid_of(batch, "landmark"), yaw[None])


@feature_set(
    "avs-intrinsic",
    types=("OBJECT", "PLACE"),
    roles=("figure", "landmark"),
    words=("relation",),
    columns=frame_columns("intrinsic"),
    scale=0.3,
    wordless=True,
)
def avs_intrinsic(batch: FactorBatch) -> FloatArray:
    """AVS in the landmark's own frame, along its longest side."""
    yaw = intrinsic_yaw(batch.boxes("landmark").corners, batch.agent)
    return avs_directions(batch.boxes("figure").centre, grid_of(batch, "landmark"), yaw[None])


@feature_set(
    "avs-log",
    types=("OBJECT", "PLACE"),
    roles=("figure", "landmark"),
    words=("relation",),
    columns=(*frame_columns("end"), *frame_columns("mean")),
    default=False,
    scale=0.3,
    wordless=True,
)
def avs_log(batch: FactorBatch) -> FloatArray:
    """AVS in the frames of the agent's ending and average orientation in the context's log.

    Off unless asked for: when objects and places are grounded, no action has been
    chosen yet, so these orientations are not known.
    """
    yaw = np.stack((batch.agent_end_yaw, batch.agent_mean_yaw))
    return avs_directions(batch.boxes("figure").centre, grid_of(batch, "landmark"), yaw)
