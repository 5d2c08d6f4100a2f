"""Outlines of things carried on from a picture of a video to later ones.

OpenCV's pyramidal Lucas-Kanade tracker follows corners within an outline; the turn, scale and shift
that most of them share move it. OpenCV's other tracker that needs no weights, MIL, takes ten times
as long (80 ms a picture instead of 8, at 480 pixels across) and keeps the size of the box.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from cv2.typing import MatLike

Outline: TypeAlias = Sequence[NDArray[np.float64]]
"""Polygons of a thing, each of shape (k, 2): x and y in pixels."""
Moved: TypeAlias = list[NDArray[np.float64]] | None
"""An outline that was carried on; None once it is lost."""

WIDTH_PX = 480
"""Width of the pictures in which corners are followed."""
STEP_S = 0.1
"""Least time between two such pictures: errors add up."""
LOST_S = 1.0
"""Time without corners to follow after which a thing is lost."""
_FEWEST = 4
_MOST_CORNERS = 200
_SLACK_S = 1e-3
_SAME_GREY = 2.0
"""Mean difference of pictures, of 255, below which what is shown stands still."""
_BACK_PX = 1.0
"""Distance within which a corner followed forth and back must come to where it was."""


@dataclass(slots=True)
class _Followed:
    outline: list[NDArray[np.float64]]
    last_s: float
    is_lost: bool = False


def carry_on(
    pictures: Iterable[tuple[float, NDArray[np.uint8]]], outlines: Sequence[Outline]
) -> Iterator[tuple[float, list[Moved]]]:
    """Yield where outlines are in pictures after the first.

    Upright boxes stay upright.

    Parameters
    ----------
    pictures
        Times in seconds, and pictures of shape (height, width, 3), red, green and blue. The
        outlines are those in the first one.
    outlines
        Outlines of things.

    Yields
    ------
    tuple
        Time of a picture, and the outlines in it, cut at its edges, with those things None that
        have been lost.
    """
    before: MatLike | None = None
    before_s = -np.inf
    followed: list[_Followed] = []
    for at_s, picture in pictures:
        if at_s < before_s + STEP_S - _SLACK_S:
            continue
        grey, scale = _small(picture)
        if before is None:
            followed = [_Followed([p * scale for p in outline], at_s) for outline in outlines]
        else:
            for one in followed:
                if not one.is_lost:
                    _follow(one, before, grey, at_s)
            edge = (picture.shape[1], picture.shape[0])
            yield (
                at_s,
                [
                    None if o.is_lost else [np.clip(p / scale, 0, edge) for p in o.outline]
                    for o in followed
                ],
            )
        before, before_s = grey, at_s


def thinned(
    times: NDArray[np.float64], values: NDArray[np.float64], tolerance: float
) -> NDArray[np.intp]:
    """Return the indices of the moments from which the others follow by interpolation.

    Parameters
    ----------
    times
        Ascending, shape (n,) with n ≥ 1.
    values
        Shape (n, d).
    tolerance
        Largest difference of a value that is left out.
    """
    kept, spans = {0, len(times) - 1}, [(0, len(times) - 1)]
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        share = ((times[first:last] - times[first]) / (times[last] - times[first]))[:, None]
        straight = values[first] + share * (values[last] - values[first])
        off = np.abs(values[first:last] - straight).max(axis=1)
        if off.max() > tolerance:
            middle = first + int(off.argmax())
            kept.add(middle)
            spans += [(first, middle), (middle, last)]
    return np.array(sorted(kept))


def _small(picture: NDArray[np.uint8]) -> tuple[MatLike, float]:
    """Return a picture in grey, and its size as a part of the original one's."""
    import cv2  # noqa: PLC0415 - large, and not always installed

    scale = min(1.0, WIDTH_PX / picture.shape[1])
    size = round(picture.shape[1] * scale), max(1, round(picture.shape[0] * scale))
    grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
    return cv2.resize(grey, size, interpolation=cv2.INTER_AREA), scale


def _follow(one: _Followed, before: MatLike, now: MatLike, at_s: float) -> None:
    import cv2  # noqa: PLC0415 - as above

    mask = _mask(before, one.outline)
    motion = _motion(before, now, mask)
    if motion is None:
        is_same = cv2.mean(cv2.absdiff(before, now), mask)[0] < _SAME_GREY
        one.last_s = at_s if is_same else one.last_s
        one.is_lost = at_s - one.last_s > LOST_S
        return
    one.last_s = at_s
    one.outline = [_moved(polygon, motion) for polygon in one.outline]
    height, width = now.shape[:2]
    corners = np.concatenate(one.outline)
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
    one.is_lost = bool((middle < 0).any() or (middle > (width, height)).any())


def _is_box(polygon: NDArray[np.float64]) -> bool:
    """Check that a polygon is an upright rectangle."""
    return len(polygon) == 4 and all(len(np.unique(polygon[:, axis])) == 2 for axis in (0, 1))


def _moved(polygon: NDArray[np.float64], motion: NDArray[np.float64]) -> NDArray[np.float64]:
    turn, shift = motion[:, :2], motion[:, 2]
    if not _is_box(polygon):
        turned: NDArray[np.float64] = polygon @ turn.T + shift
        return turned
    low, high = polygon.min(axis=0), polygon.max(axis=0)
    middle, half = turn @ (low + high) / 2 + shift, np.hypot(*turn[:, 0]) * (high - low) / 2
    upright: NDArray[np.float64] = np.where(polygon == low, middle - half, middle + half)
    return upright


def _mask(picture: MatLike, outline: Outline) -> MatLike:
    """Return a mask of the pixels that show a thing."""
    import cv2  # noqa: PLC0415 - as above

    mask = np.zeros_like(picture)
    for polygon in outline:
        if _is_box(polygon):  # its corners mostly show what is behind the thing
            low, high = polygon.min(axis=0), polygon.max(axis=0)
            middle, half = (low + high) / 2, np.maximum((high - low) / 2, 1)
            centre, axes = np.round([middle, half]).astype(int).tolist()
            cv2.ellipse(mask, centre, axes, 0, 0, 360, 255, -1)
        else:
            cv2.fillPoly(mask, [np.round(polygon).astype(np.int32)], 255)
    return mask


def _motion(before: MatLike, now: MatLike, mask: MatLike) -> NDArray[np.float64] | None:
    """Return the matrix, of shape (2, 3), that moves a thing; None if too few corners are left."""
    import cv2  # noqa: PLC0415 - as above

    start = cv2.goodFeaturesToTrack(before, _MOST_CORNERS, 0.005, 3, mask=mask)
    if start is None or len(start) < _FEWEST:
        return None
    window: dict[str, Any] = {"winSize": (21, 21), "maxLevel": 4}
    forth, is_forth, _ = cv2.calcOpticalFlowPyrLK(before, now, start, np.empty(0), **window)
    back, is_back, _ = cv2.calcOpticalFlowPyrLK(now, before, forth, np.empty(0), **window)
    is_near = np.linalg.norm(start - back, axis=2).ravel() < _BACK_PX
    good = (is_forth.ravel() == 1) & (is_back.ravel() == 1) & is_near
    if good.sum() < _FEWEST:
        return None
    transform, _ = cv2.estimateAffinePartial2D(start[good], forth[good], ransacReprojThreshold=2.0)
    motion: NDArray[np.float64] | None = transform
    return motion
