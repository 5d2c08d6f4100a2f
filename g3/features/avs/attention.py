"""Attentional vector sums (:mod:`g3.features.avs.vector_sums`) as machine code.

Rows are looked at in blocks: what is known of a block's rows stays in the nearest cache, and the
processor takes several rows in one step.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from numpy.polynomial import Chebyshev, Polynomial

from g3.features.avs.attention_arrays import (
    ATTENTION_WIDTH,
    CORNER_INSET,
    INTERCEPT,
    NEAR,
    PLACES,
    PRECISION_DEG,
    SLOPE_PER_DEGREE,
    WEIGHTS,
)
from g3.features.bodies import IntArray, Singles
from g3.geometry.compiled import compiled
from g3.groundings import FloatArray

BLOCK = 64
"""Rows that are looked at together."""

Single = np.float32

ZERO, HALF, ONE, INFINITE = Single(0), Single(0.5), Single(1), Single(np.inf)
HALF_TURN, QUARTER_TURN = Single(np.pi), Single(np.pi / 2)
INSET, WIDTH, NEAREST, LEAST_M = (
    Single(CORNER_INSET),
    Single(ATTENTION_WIDTH),
    Single(NEAR),
    Single(1e-6),
)
TINY = Single(1e-30)
PER_RADIAN = Single(180 / np.pi / PRECISION_DEG)
PER_STEP = SLOPE_PER_DEGREE * PRECISION_DEG
"""Loss of the degree with each step of the precision."""


def _polynomial(function: Callable[[FloatArray], FloatArray], degree: int) -> tuple[Single, ...]:
    """Coefficients of a function on [0, 1], the highest power first."""
    series = Chebyshev.interpolate(function, degree, domain=[0, 1])
    return tuple(series.convert(kind=Polynomial).coef[::-1].astype(Single))


BITS_PER_NATURAL = Single(1 / np.log(2))
LEAST_POWER = Single(-126)
BIAS, FRACTION = np.int32(127), np.int32(23)
"""Layout of a power of two in single precision."""
POWER = _polynomial(np.exp2, 6)
ARCTAN = _polynomial(lambda square: np.arctan(np.sqrt(square)) / np.sqrt(square), 8)


@compiled("f4(f4)")
def exp_minus(x: Single) -> Single:
    """Vectorisable exp(-x) for x ≥ 0."""
    power = max(-BITS_PER_NATURAL * x, LEAST_POWER)
    whole = np.floor(power)
    rest = power - whole
    value = ZERO
    for coefficient in POWER:
        value = value * rest + coefficient
    result: Single = value * np.int32((np.int32(whole) + BIAS) << FRACTION).view(Single)
    return result


@compiled("f4(f4, f4)")
def angle(across: Single, along: Single) -> Single:
    """Return the angle of a vector with straight ahead, from 0 to half a turn."""
    x, y = abs(along), abs(across)
    longer = max(x, y)
    ratio = min(x, y) / max(longer, TINY)
    square = ratio * ratio
    value = ZERO
    for coefficient in ARCTAN:
        value = value * square + coefficient
    value *= ratio
    value = QUARTER_TURN - value if y > x else value
    result: Single = HALF_TURN - value if along < ZERO else value
    return result


@compiled("void(f4[:, ::1], u1, UniTuple(f4, 4), UniTuple(f4[:, :, ::1], 2), i8)")
def view_landmark(
    landmark: Singles,
    corners: int,
    view: tuple[Single, Single, Single, Single],
    seen: tuple[Singles, Singles],
    i: int,
) -> None:
    """See row i from its figure's line ahead, and find where the line meets the landmark.

    Parameters
    ----------
    landmark, corners
        Its corners (k, 2), and how many there are in the block.
    view
        The figure's x and y, and cosine and sine of the heading.
    seen
        The border, (2, k + 1, rows), gets how far the corners are ahead and to the left; the
        figure, (3, 2, rows), how far it is ahead of the front and where that is, the same of the
        back, and how far it is to the left.
    """
    x, y, cos, sin = view
    border, figure = seen
    low, high = INFINITE, -INFINITE
    for e in range(corners):
        u, v = landmark[e, 0], landmark[e, 1]
        border[0, e, i] = u * cos + v * sin
        border[1, e, i] = v * cos - u * sin
        low, high = min(low, border[1, e, i]), max(high, border[1, e, i])
    inset = INSET * (high - low)
    ahead, aside = x * cos + y * sin, y * cos - x * sin
    line = min(max(aside, low + inset), high - inset)
    border[0, corners, i], border[1, corners, i] = border[0, 0, i], border[1, 0, i]
    front, back = INFINITE, -INFINITE
    for e in range(corners):
        along = border[0, e + 1, i] - border[0, e, i]
        across = border[1, e + 1, i] - border[1, e, i]
        border[1, e, i] -= line
        # Corners run counter-clockwise, so that edges that face ahead lead to the left.
        met = border[0, e, i] - along / across * border[1, e, i]
        front = min(front, met if across > ZERO else INFINITE)
        back = max(back, met if across < ZERO else -INFINITE)
    border[1, corners, i] = border[1, 0, i]
    figure[0, 0, i], figure[0, 1, i] = ahead - front, front
    figure[1, 0, i], figure[1, 1, i] = ahead - back, back
    figure[2, 0, i] = aside - line


@compiled("void(f4[:, :, ::1], i8, UniTuple(f4[::1], 3), i8, f4[:, ::1])")
def add_attention(
    border: Singles,
    corners: int,
    view: tuple[Singles, Singles, Singles],
    rows: int,
    total: Singles,
) -> None:
    """Sum attention, and attention times point, over landmarks' points.

    Take a ray of length R, in units of the figure's distance. The integral of r exp(-r) along it is
    1 - (1 + R) exp(-R); that of r² exp(-r) is twice that, less R² exp(-R).

    Parameters
    ----------
    border, corners
        As :func:`view_landmark` sees them.
    view
        Distance to the focus of attention ahead, and the figure's distance ahead and to its left.
    total
        Gets the sums, (3 and space, rows).
    """
    focus, ahead, aside = view
    for i in range(rows):
        distance = np.sqrt(ahead[i] * ahead[i] + aside[i] * aside[i])
        total[0, i] = total[1, i] = total[2, i] = ZERO
        total[3, i] = ONE / (WIDTH * max(distance, LEAST_M))
    for e in range(corners):
        for p in range(len(PLACES)):
            place, weight = PLACES[p], WEIGHTS[p]
            for i in range(rows):
                x, y = border[0, e, i] - focus[i], border[1, e, i]
                along, across = border[0, e + 1, i] - border[0, e, i], border[1, e + 1, i] - y
                share = (x * across - y * along) * weight
                x += place * along
                y += place * across
                ray = max(np.sqrt(x * x + y * y) * total[3, i], NEAREST)
                attention = exp_minus(ray)
                part = ONE / ray
                lone = (ONE - (ONE + ray) * attention) * part * part
                drawn = (lone + lone - attention) * part * share
                total[0, i] += lone * share
                total[1, i] += x * drawn
                total[2, i] += y * drawn


@compiled(
    "void(Tuple((f4[:, :, ::1], u1[::1], f8[:, ::1], i8[::1])), "
    "f8[:, ::1], f4[:, :, ::1], f8[:, :, ::1])"
)
def degrees(
    landmarks: tuple[Singles, npt.NDArray[np.uint8], FloatArray, IntArray],
    points: FloatArray,
    heading: Singles,
    result: FloatArray,
) -> None:
    """Degrees to which points lie ahead, left, behind and right of landmarks.

    Parameters
    ----------
    landmarks
        Fields of :class:`g3.features.avs.vector_sums.Footprints`: `seen`, `corners`, `centre`,
        `row`.
    points
        Figures (n, 2).
    heading
        Cosine and sine of where frames head, (2, frames, n).
    result
        Gets the degrees, (n, frames, 4).
    """
    seen, corners, centre, row = landmarks
    border = np.empty((2, seen.shape[1] + 1, BLOCK), Single)
    figure, total = np.empty((3, 2, BLOCK), Single), np.empty((4, BLOCK), Single)
    for start in range(0, len(row), BLOCK):
        rows = min(BLOCK, len(row) - start)
        most = corners[row[start : start + rows]].max()
        for direction in range(2 * heading.shape[1]):
            frame, left = direction >> 1, direction & 1
            for i in range(rows):
                place = row[start + i]
                x = Single(points[start + i, 0] - centre[place, 0])
                y = Single(points[start + i, 1] - centre[place, 1])
                cos, sin = heading[0, frame, start + i], heading[1, frame, start + i]
                # After a quarter turn, the left is ahead.
                cos, sin = (-sin, cos) if left else (cos, sin)
                view_landmark(seen[place], most, (x, y, cos, sin), (border, figure), i)
            for back in range(2):
                view = figure[back, 1], figure[back, 0], figure[2, 0]
                add_attention(border, most, view, rows, total)
                for i in range(rows):
                    along = total[0, i] * figure[back, 0, i] - total[1, i]
                    across = total[0, i] * figure[2, 0, i] - total[2, i]
                    deviation = angle(across, -along if back else along)
                    total[3, i] = np.floor(deviation * PER_RADIAN + HALF)
                for i in range(rows):
                    degree = INTERCEPT + PER_STEP * total[3, i]
                    result[start + i, frame, 2 * back + left] = min(max(degree, 0.0), 1.0)
