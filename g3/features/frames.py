"""Directions in a frame of reference: "left of", "in front of", "behind" (section 3.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from g3.features.batch import Boxes, FactorBatch
from g3.features.registry import Column, Columns, feature_set
from g3.geometry import BoolArray, centroid, cross, following, length, rotate
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

CORNERS = 4
"""What most footprints have."""

GRID = (np.arange(5) + 0.5) / 5


def attention_vector_sum(
    points: FloatArray, landmarks: FloatArray, direction: FloatArray
) -> FloatArray:
    """Degree to which a point lies in a direction from a landmark, between 0 and 1.

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
        Convex footprints, shape (n, k, 2), in metres.
    direction
        Unit vectors, shape (n, 2).

    Returns
    -------
    FloatArray
        Shape (n,).

    References
    ----------
    .. [1] T. Regier and L. A. Carlson, "Grounding spatial language in perception: an
       empirical and computational investigation", Journal of Experimental Psychology:
       General 130(2), 2001.
    """
    return _degree(points, landmarks, footprint_grid(landmarks), direction)


@dataclass(frozen=True, slots=True)
class Grid:
    """Points spread over footprints, and the share of the area that each stands for.

    Parameters
    ----------
    centre
        Of each footprint, shape (n, 2).
    x, y
        The points, seen from there, shape (n, g).
    share
        Shape (n, g).
    simple
        Whether only those of the first `CORNERS` corners have a share, shape (n,).
    """

    centre: FloatArray
    x: FloatArray
    y: FloatArray
    share: FloatArray
    simple: BoolArray


def _degree(
    points: FloatArray, landmarks: FloatArray, grid: Grid, direction: FloatArray
) -> FloatArray:
    focus = _focus(points, landmarks, direction)
    sigma = np.maximum(length(points - focus), 1e-6)
    x, y = (focus - grid.centre).T[:, :, None]
    attention = _attention(grid, x, y, (-ATTENTION_WIDTH * sigma)[:, None], landmarks.shape[1])
    drawn = [np.einsum("ng,ng->n", attention, part) for part in (grid.x, grid.y)]
    total = (points - grid.centre) * attention.sum(axis=1)[:, None] - np.stack(drawn, axis=1)
    along = (total * direction).sum(axis=1)
    deviation = np.degrees(np.arctan2(np.abs(cross(direction, total)), along))
    degree: FloatArray = np.clip(INTERCEPT + SLOPE_PER_DEGREE * deviation, 0.0, 1.0)
    return degree


def _attention(
    grid: Grid, x: FloatArray, y: FloatArray, width: FloatArray, corners: int
) -> FloatArray:
    """Attention at the points of grids, shape (n, g); points without a share aren't looked at."""
    attention = np.zeros(grid.x.shape)
    # Most footprints are boxes, among some with more corners that decide how wide the arrays are.
    for rows, used in ((grid.simple, CORNERS), (~grid.simple, corners)):
        chosen = np.flatnonzero(rows)
        if len(chosen) == 0:
            continue
        some = slice(None) if len(chosen) == len(rows) else chosen
        by_corner = [
            values.reshape(len(rows), -1, corners)[some, :, :used]
            for values in (grid.x, grid.y, grid.share)
        ]
        dx, dy = by_corner[0] - x[some, :, None], by_corner[1] - y[some, :, None]
        found = by_corner[2] * np.exp(np.sqrt(dx**2 + dy**2) / width[some, :, None])
        attention.reshape(len(rows), -1, corners)[some, :, :used] = found
    return attention


def _focus(points: FloatArray, landmarks: FloatArray, direction: FloatArray) -> FloatArray:
    """The border point furthest in the direction, as nearly in line with the figure as can be."""
    across = np.stack((-direction[:, 1], direction[:, 0]), axis=1)
    side = (landmarks * across[:, None]).sum(axis=2)
    ahead = (landmarks * direction[:, None]).sum(axis=2)
    low, high = side.min(axis=1), side.max(axis=1)
    inset = CORNER_INSET * (high - low)
    target = np.clip((points * across).sum(axis=1), low + inset, high - inset)[:, None]
    next_side, next_ahead = following(side), following(ahead)
    span = next_side - side
    flat = np.abs(span) < 1e-9
    ratio = (target - side) / np.where(flat, 1.0, span)
    on_edge = (ratio >= -1e-9) & (ratio <= 1 + 1e-9) & ~flat
    height = np.where(on_edge, ahead + ratio * (next_ahead - ahead), -np.inf).max(axis=1)
    best = np.where(np.isfinite(height), height, ahead.max(axis=1))
    focus: FloatArray = target * across + best[:, None] * direction
    return focus


def footprint_grid(landmarks: FloatArray) -> Grid:
    """Points on rays from the centre of each footprint to points along its border.

    A repeated corner stands for no area; where there is no area at all, shares go by the
    border's length.
    """
    n = len(landmarks)
    centre = centroid(landmarks)
    arm, edge = landmarks - centre[:, None], following(landmarks) - landmarks
    border = arm[:, None] + GRID[:, None, None] * edge[:, None]
    x, y = (
        (GRID[:, None] * border[..., axis].reshape(n, 1, -1)).reshape(n, -1) for axis in range(2)
    )
    triangle, side = cross(arm, edge), length(edge)
    flat = triangle.sum(axis=1) <= 1e-12 * (side**2).sum(axis=1)
    share = np.where(flat[:, None], side + 1e-12, np.maximum(triangle, 0.0))
    along = np.tile(share, len(GRID))
    simple: BoolArray = ~np.any(share[:, CORNERS:], axis=1)
    return Grid(centre, x, y, (GRID[:, None] * along[:, None]).reshape(n, -1), simple)


def avs_directions(
    points: FloatArray, landmarks: FloatArray, yaw: FloatArray, grid: Grid | None = None
) -> FloatArray:
    """AVS for the four directions of frames with heading yaw (n,); shape (n, 4).

    The landmarks' grid can be given if it is known.
    """
    grid = grid or footprint_grid(landmarks)
    turns = np.arange(len(DIRECTIONS)) * np.pi / 2
    return np.column_stack([_turned(points, landmarks, yaw, grid, turn) for turn in turns])


def avs_ahead(points: FloatArray, landmarks: FloatArray, yaw: FloatArray, grid: Grid) -> FloatArray:
    """AVS for the front alone, shape (n,)."""
    return _turned(points, landmarks, yaw, grid, 0.0)


def _turned(
    points: FloatArray, landmarks: FloatArray, yaw: FloatArray, grid: Grid, turn: float
) -> FloatArray:
    forward = np.stack((np.cos(yaw), np.sin(yaw)), axis=1)
    return _degree(points, landmarks, grid, rotate(forward, np.full(len(yaw), turn)))


def speaker_yaw(agent: FloatArray, landmarks: FloatArray) -> FloatArray:
    """Heading of the line of sight from the agent's start (n, 3) to each landmark; (n,)."""
    sight = centroid(landmarks) - agent[:, :2]
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


def landmark_grid(batch: FactorBatch) -> Grid:
    """Points spread over the landmarks, for all sets that need them."""
    return batch.once("landmark grid", lambda b: footprint_grid(b.boxes("landmark").corners))


def _centre(prisms: Boxes) -> FloatArray:
    return centroid(prisms.corners)


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
    points, landmarks = _centre(batch.boxes("figure")), batch.boxes("landmark").corners
    return avs_directions(points, landmarks, batch.agent[:, 2], landmark_grid(batch))


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
    landmarks = batch.boxes("landmark").corners
    yaw = speaker_yaw(batch.agent, landmarks)
    return avs_directions(_centre(batch.boxes("figure")), landmarks, yaw, landmark_grid(batch))


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
    landmarks = batch.boxes("landmark").corners
    yaw = intrinsic_yaw(landmarks, batch.agent)
    return avs_directions(_centre(batch.boxes("figure")), landmarks, yaw, landmark_grid(batch))


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
    points, landmarks = _centre(batch.boxes("figure")), batch.boxes("landmark").corners
    return np.column_stack(
        [
            avs_directions(points, landmarks, yaw, landmark_grid(batch))
            for yaw in (batch.agent_end_yaw, batch.agent_mean_yaw)
        ]
    )
