"""The yard that a context takes place in: markings painted on its ground, and its edge.

Nothing is written on the ground: people shall find their own words for what they see.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from corpus_tools.world.looks.atlas import Finish, colour
from corpus_tools.world.looks.parts import Part, join, moved, quad, quads, tapered
from g3.geometry.plane import convex_hull, rotate
from g3.groundings import Context, FloatArray
from g3.short_repr import short_repr

MARGIN_M = 7.0
"""From the outermost object or place to the edge of the yard."""
LINE_M = 0.15
"""Width of painted lines."""
PAINT_M = 0.008
"""Height of paint above the ground, in metres, so that it is seen from far away."""
HATCH_M = 1.1
"""From one stripe of a named place to the next."""

_EDGE_LINE, _LANE_LINE = 1.0, 5.0
_DASH, _DASH_EVERY = 1.5, 4.0
_PIECE, _MOST_PIECES = 4.0, 40


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Yard:
    """A rectangle of ground."""

    middle: FloatArray
    """Shape (2,)."""
    half: FloatArray
    """Half its length and half its width, shape (2,)."""
    yaw: float
    """Direction of its length."""


def yard_of(context: Context) -> Yard:
    """Return the yard with everything in it, laid out as most objects stand."""
    yaws = np.array([item.trajectory.yaw[0] for item in context.objects])
    yaw = float(np.angle(np.exp(4j * yaws).sum())) / 4
    corners = np.concatenate(
        [item.prism.xy for item in context.objects]
        + [place.prism.xy for place in context.places]
        + [item.trajectory.xyz[:, :2] for item in context.objects]
    )
    straight = rotate(corners, np.full(len(corners), -yaw))
    low, high = straight.min(axis=0), straight.max(axis=0)
    middle = rotate((low + high)[None] / 2, np.array([yaw]))[0]
    return Yard(middle, (high - low) / 2 + MARGIN_M, yaw)


def markings(context: Context, yard: Yard, ground_m: float) -> list[Part]:
    """Build lines around the yard and frames of the named places."""
    z = ground_m + PAINT_M
    edge, lane = yard.half - _EDGE_LINE, yard.half - _LANE_LINE
    yellow, white = colour("yellow", 0.95, 0.95), colour("white", 0.97, 0.97)
    lines = []
    for axis in (0, 1):
        for side in (-1, 1):
            length, across = edge[axis], side * edge[1 - axis]
            lines.append(_line(axis, (-length, length), across, yellow))
            n = min(_MOST_PIECES, int(2 * lane[axis] / _DASH_EVERY))
            for k in range(n):
                start = _DASH_EVERY * (k - (n - 1) / 2) - _DASH / 2
                lines.append(_line(axis, (start, start + _DASH), side * lane[1 - axis], white))
    ground = [moved(join(lines), (*yard.middle, z), yard.yaw)]
    for place in context.places:
        hull = convex_hull(place.prism.xy)
        if place.name and len(hull) > 2:
            ground += _zone(hull, z)
    return ground


def barrier(yard: Yard, ground_m: float) -> list[Part]:
    """Build low concrete walls around the yard, in pieces."""
    return [barrier_side(yard, ground_m, quarter) for quarter in range(4)]


def barrier_side(yard: Yard, ground_m: float, quarter: int) -> Part:
    """Build the low wall of one side: right of the yard's direction, then before it, and so on."""
    finish = colour("concrete", 0.75, 1.1)
    along, across = yard.half[quarter % 2], yard.half[1 - quarter % 2]
    n = max(1, min(_MOST_PIECES, round(2 * along / _PIECE)))
    half = 0.975 * along / n
    wall = join(
        tapered(
            (x - half, -0.25 - across, 0.0),
            (x + half, 0.25 - across, 0.75),
            (x - half, -0.1 - across),
            (x + half, 0.1 - across),
            finish,
            without="-z",
        )
        for x in (2 * np.arange(n) + 1 - n) / n * along
    )
    return moved(wall, (*yard.middle, ground_m), yard.yaw + np.pi / 2 * quarter)


def _line(axis: int, along: tuple[float, float], across: float, finish: Finish) -> Part:
    """Build a line on the ground, parallel to x (axis 0) or y (1)."""
    half = LINE_M / 2
    ends = np.array([(along[0], across - half), (along[1], across + half)])
    (x0, y0), (x1, y1) = ends if axis == 0 else ends[:, ::-1]
    return quad([(x0, y0, 0), (x1, y0, 0), (x1, y1, 0), (x0, y1, 0)], finish)


def _zone(hull: FloatArray, z: float) -> list[Part]:
    """Build a frame with thin stripes in it."""
    middle = hull.mean(axis=0)
    reach = np.linalg.norm(hull - middle, axis=1, keepdims=True)
    inner = middle + (hull - middle) * np.maximum(1 - 1.5 * LINE_M / np.maximum(reach, 0.01), 0)
    yellow, pale = colour("yellow", 0.95, 0.95), colour("white", 0.97, 0.97)
    frame = hull, np.roll(hull, -1, axis=0), np.roll(inner, -1, axis=0), inner
    parts = [_flat(np.stack(frame, axis=1), z, yellow)]
    edge = hull[1] - hull[0]
    slant = rotate(edge[None] / np.linalg.norm(edge), np.array([np.pi / 4]))[0]
    normal = np.array([-slant[1], slant[0]])
    offsets = inner @ normal
    n = min(_MOST_PIECES, int((offsets.max() - offsets.min()) / HATCH_M))
    for offset in offsets.mean() + HATCH_M * (np.arange(n) - (n - 1) / 2):
        ends = _crossing(inner, normal, offset, slant)
        if ends is not None:
            a, b = ends
            shift = 0.4 * LINE_M * normal
            stripe = np.array([[a - shift, b - shift, b + shift, a + shift]])
            parts.append(_flat(stripe, z, pale))
    return parts


def _crossing(
    hull: FloatArray, normal: FloatArray, offset: float, slant: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    """Return the points where a line enters and leaves a convex polygon, in its direction."""
    height = hull @ normal - offset
    points = []
    for i in range(len(hull)):
        a, b = height[i], height[(i + 1) % len(hull)]
        if (a < 0) != (b < 0):
            points.append(hull[i] + a / (a - b) * (hull[(i + 1) % len(hull)] - hull[i]))
    if len(points) != 2:
        return None
    first, last = sorted(points, key=lambda point: float(point @ slant))
    return first, last


def _flat(corners: FloatArray, z: float, finish: Finish) -> Part:
    """Build surfaces on the ground with corners of shape (n, 4, 2)."""
    return quads(np.insert(corners, 2, z, axis=2), finish)
