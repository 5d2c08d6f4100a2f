"""Curves of many numbers over time, in a file that can be read in parts.

The layout is that of safetensors (https://github.com/huggingface/safetensors): the length of a
header in eight bytes, the header in JSON, and arrays of little-endian float32 one after the other.

- The array ``0`` has the values, shape (samples, curves), `rate` of them a second. Gaps are NaN.
- The array ``k`` has the least and the greatest of `STEP` rows of the array before, shape (n,
  curves, 2), so that a long time is drawn from few numbers.

The coarsest array comes first: the beginning of a file is enough to draw all of it.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from g3.errors import FormatError
from g3.storage import regular_file

SUFFIX = ".safetensors"
KIND = "curves-1"
STEP = 4
"""Number of rows of an array that are a row of the next one."""
FEWEST = 256
"""An array of so few rows is the last one."""
MOST_CURVES = 128
LONGEST_NAME = 100
HEAD_BYTES = 1 << 16
"""Largest size of a header with its length, which ``curve-file.js`` reads at once."""
_ROWS_AT_ONCE = 1 << 14
_FIX = "import the dataset again"

Values = npt.NDArray[np.float32]


class Curve(msgspec.Struct, frozen=True):
    """A curve's name, and that of the group with which it is drawn."""

    group: str
    name: str


@dataclass(frozen=True, slots=True)
class CurveFile:
    """The header of a file of curves."""

    curves: tuple[Curve, ...]
    rate: float
    """Samples a second."""
    samples: int


class _Array(msgspec.Struct, frozen=True):
    dtype: str
    shape: tuple[int, ...]
    data_offsets: tuple[int, int]


class _Metadata(msgspec.Struct, frozen=True):
    kind: str
    rate: str
    curves: str


def write_curves(
    file: Path, curves: Sequence[Curve], rate: float, samples: int, pieces: Iterable[Values]
) -> None:
    """Write a file of curves; memory stays flat however long they are.

    Names are shortened if the header would have more than `HEAD_BYTES`.

    Parameters
    ----------
    rate
        Samples a second.
    samples
        Number of samples; those that `pieces` don't have are gaps.
    pieces
        The samples in their order, arrays of shape (n, curves).
    """
    shapes = _shapes(samples, len(curves))
    header, offsets = _header(curves, rate, shapes)
    longest = LONGEST_NAME
    while len(header) > HEAD_BYTES:
        longest //= 2
        curves = [Curve(curve.group[:longest], curve.name[:longest]) for curve in curves]
        header, offsets = _header(curves, rate, shapes)
    sizes = [4 * int(np.prod(shape, dtype=np.int64)) for shape in shapes]
    with file.open("wb") as content:
        content.write(header)
        content.truncate(len(header) + sum(sizes))
    arrays: list[Any] = [
        np.memmap(file, "<f4", "r+", len(header) + offset, shape)
        for offset, shape in zip(offsets, shapes, strict=True)
    ]
    row = 0
    for piece in pieces:
        rows = piece[: samples - row]
        finite = np.isfinite(rows)
        arrays[0][row : row + len(rows)] = np.where(finite, rows, np.nan)
        row += len(rows)
    arrays[0][row:] = np.nan
    for finer, coarser in pairwise(arrays):
        for first in range(0, len(coarser), _ROWS_AT_ONCE):
            part = coarser[first : first + _ROWS_AT_ONCE]
            part[:] = _extremes(finer[STEP * first : STEP * (first + len(part))])
    for array in arrays:
        array.flush()


def _extremes(rows: Values) -> Values:
    """Return the least and the greatest of each `STEP` rows, shape (n, curves, 2)."""
    edges = np.arange(0, len(rows), STEP)
    low, high = (rows[..., 0], rows[..., 1]) if rows.ndim == 3 else (rows, rows)
    least = np.fmin.reduceat(low, edges, axis=0)
    return np.stack((least, np.fmax.reduceat(high, edges, axis=0)), axis=-1)


def read_header(file: Path) -> CurveFile:
    """Read the header of a file of curves, and compare it with the file's size."""
    try:
        with regular_file.opened(file) as content:
            size = os.fstat(content.fileno()).st_size
            (length,) = struct.unpack("<Q", content.read(8))
            if length > HEAD_BYTES - 8:
                raise ValueError("its header is too long")
            arrays = msgspec.json.decode(content.read(length), type=dict[str, Any])
        metadata = msgspec.convert(arrays.pop("__metadata__", None), _Metadata)
        curves = msgspec.json.decode(metadata.curves, type=tuple[Curve, ...])
        arrays_read = msgspec.convert(arrays, dict[str, _Array])
        samples, rate = arrays_read["0"].shape[0], float(metadata.rate)
        if metadata.kind != KIND or not 0 < len(curves) <= MOST_CURVES or not 0 < rate < 1e6:
            raise ValueError("it has no curves")
        if not 0 < samples <= size:
            raise ValueError("its header doesn't fit its size")
        shapes = _shapes(samples, len(curves))
        _, offsets = _header(curves, rate, shapes)
        expected = {
            str(k): _Array("F32", shape, (offset, offset + 4 * int(np.prod(shape))))
            for k, (offset, shape) in enumerate(zip(offsets, shapes, strict=True))
        }
        if arrays_read != expected or size != 8 + length + arrays_read["0"].data_offsets[1]:
            raise ValueError("its header doesn't fit its size")
    except (OSError, ValueError, LookupError, struct.error, msgspec.MsgspecError) as error:
        what = f"this is no whole file of curves: {error}"
        raise FormatError(what, where=str(file), fix=_FIX) from error
    return CurveFile(curves, rate, samples)


def _shapes(samples: int, curves: int) -> list[tuple[int, ...]]:
    shapes: list[tuple[int, ...]] = [(samples, curves)]
    while shapes[-1][0] > FEWEST:
        shapes.append((ceil(shapes[-1][0] / STEP), curves, 2))
    return shapes


def _header(
    curves: Sequence[Curve], rate: float, shapes: Sequence[tuple[int, ...]]
) -> tuple[bytes, list[int]]:
    """Return the header with its length, and where the arrays begin behind it."""
    arrays: dict[str, Any] = {}
    offsets = [0] * len(shapes)
    offset = 0
    for level in reversed(range(len(shapes))):
        end = offset + 4 * int(np.prod(shapes[level], dtype=np.int64))
        offsets[level] = offset
        arrays[str(level)] = _Array("F32", shapes[level], (offset, end))
        offset = end
    named = msgspec.json.encode(list(curves)).decode()
    metadata = _Metadata(KIND, repr(float(rate)), named)
    content = msgspec.json.encode({"__metadata__": metadata, **arrays})
    content += b" " * (-len(content) % 8)  # arrays begin at whole words
    return struct.pack("<Q", len(content)) + content, offsets
