"""Depth maps in false colours, with a scale in metres below them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import log
from typing import Any

import numpy as np
import numpy.typing as npt

from corpus_tools.episodes.films import RESTORE, Picture
from g3.errors import FormatError

Metres = npt.NDArray[np.float32]
"""Distances, shape (height, width); NaN where none was measured."""

MOST_M = 1000.0
_FALLBACK_M = (0.1, 10.0)
_OUTLIERS = 1.0
"""Percent of the distances at each end that have the colour of the nearest or the farthest."""
_SAMPLED = 4096
"""Number of pixels of a frame by which a scale is chosen."""
_LEAST_WIDTH = 320
_TICKS = 5


@dataclass(frozen=True, slots=True)
class DepthScale:
    """The distances of the first and the last colour, in metres."""

    near_m: float
    far_m: float


def scale_of(frames: Iterable[Metres]) -> DepthScale:
    """Return a scale for some frames; outliers are beyond it."""
    seen = [np.zeros(0, np.float32)]
    for metres in frames:
        known = metres[np.isfinite(metres)]
        seen.append(known[:: max(len(known) // _SAMPLED, 1)])
    distances = np.concatenate(seen)
    if not len(distances):
        return DepthScale(*_FALLBACK_M)
    near, far = map(float, np.percentile(distances, (_OUTLIERS, 100 - _OUTLIERS)))
    return DepthScale(near, max(far, near + 0.01))


def false_colours(metres: Metres, scale: DepthScale, where: str) -> Picture:
    """Return a frame from red, near, to blue, far; black is unknown.

    Small frames are enlarged, so that the scale can be read.
    """
    import cv2  # noqa: PLC0415 - large, and not always installed

    times = max(1, -(-_LEAST_WIDTH // metres.shape[1]))
    large = np.repeat(np.repeat(metres, times, axis=0), times, axis=1)
    is_known = np.isfinite(large)
    share = (np.where(is_known, large, scale.far_m) - scale.near_m) / (scale.far_m - scale.near_m)
    colours = cv2.applyColorMap(_bytes(1 - share), cv2.COLORMAP_TURBO)
    colours[~is_known] = 0
    picture = np.vstack((colours, _legend(scale, large.shape[1])))
    return Picture(np.ascontiguousarray(picture[..., ::-1]), where)


def _legend(scale: DepthScale, width: int) -> npt.NDArray[np.uint8]:
    """Return a strip with the colours and their distances: blue, green and red."""
    import cv2  # noqa: PLC0415 - as above

    size = width / 640 * 0.55 if width > 640 else 0.42
    height = round(44 * size / 0.42) // 2 * 2
    strip = np.zeros((height, width, 3), np.uint8)
    ramp = _bytes(1 - np.linspace(0, 1, width)[None])
    strip[: height // 3] = cv2.applyColorMap(ramp, cv2.COLORMAP_TURBO)
    for number in range(_TICKS):
        share = number / (_TICKS - 1)
        text = f"{scale.near_m + share * (scale.far_m - scale.near_m):.2f} m"
        (length, _), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, size, 1)
        left = round(share * (width - length))
        at, white = (left, height - height // 4), (255, 255, 255)
        cv2.putText(strip, text, at, cv2.FONT_HERSHEY_SIMPLEX, size, white, 1, cv2.LINE_AA)
    return strip


def _bytes(shares: npt.NDArray[Any]) -> npt.NDArray[np.uint8]:
    levels: npt.NDArray[np.uint8] = np.rint(255 * np.clip(shares, 0, 1)).astype(np.uint8)
    return levels


def measured(values: npt.NDArray[Any], unit: Any) -> Metres:
    """Return raw distances in metres.

    Parameters
    ----------
    values
        Whole numbers are millimetres, others metres, unless there is a unit; 0 is unknown.
    unit
        ``m`` or ``mm``; anything else counts as none.
    """
    is_whole = np.issubdtype(values.dtype, np.integer)
    per_metre = {"m": 1.0, "mm": 1000.0}.get(str(unit), 1000.0 if is_whole else 1.0)
    return _known(values.astype(np.float32) / np.float32(per_metre))


@dataclass(frozen=True, slots=True)
class Quantization:
    """The way in which LeRobot makes distances to the grey of videos."""

    near_m: float = 0.01
    far_m: float = 10.0
    shift_m: float = 3.5
    is_log: bool = True

    def metres(self, grey: npt.NDArray[np.unsignedinteger[Any]], most: int) -> Metres:
        """Return the distances of grey, of which `most` is the brightest; black is unknown."""
        share = np.where(grey > 0, grey.astype(np.float32) / most, np.float32(np.nan))
        if self.is_log:
            low, high = log(self.near_m + self.shift_m), log(self.far_m + self.shift_m)
            return _known((np.exp(low + share * (high - low)) - self.shift_m).astype(np.float32))
        return _known((self.near_m + share * (self.far_m - self.near_m)).astype(np.float32))


def quantization(info: Mapping[str, Any], where: str) -> Quantization:
    """Return the quantization that a feature's ``info`` states, else LeRobot's own."""
    usual = Quantization()

    def number(name: str, default: float) -> float:
        value = info.get(f"video.{name}", info.get(name))
        if value is None:
            return default
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < MOST_M:
            raise FormatError(f"{name} is {value!r:.40}", where=where, fix=RESTORE)
        return float(value)

    near_m, far_m = number("depth_min", usual.near_m), number("depth_max", usual.far_m)
    shift_m = number("shift", usual.shift_m)
    is_log = bool(info.get("video.use_log", info.get("use_log", usual.is_log)))
    if not 0 <= near_m < far_m or (is_log and near_m + shift_m <= 0):
        what = f"distances from {near_m:g} to {far_m:g} m, shifted by {shift_m:g} m, are none"
        raise FormatError(what, where=where, fix=RESTORE)
    return Quantization(near_m, far_m, shift_m, is_log)


def _known(metres: Metres) -> Metres:
    return np.where((metres > 0) & (metres < MOST_M), metres, np.float32(np.nan))
