"""Masks of things as COCO writes them: the lengths of runs, down column by column."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import msgspec
import numpy as np
from cv2.typing import MatLike

MANY = 100
"""Corners from which on the steps of pixels are smoothed away."""
WHY = "its mask is no run-length encoding of COCO"


class Mask(msgspec.Struct, frozen=True):
    """A mask: runs of pixels outside and inside a thing, in turn.

    Parameters
    ----------
    size
        Height and width of the picture, in pixels.
    counts
        The runs' lengths, or the string into which COCO's tools compress them.
    """

    size: tuple[int, int]
    counts: list[int] | str


def outlines(mask: Mask) -> list[list[list[float]]]:
    """Around a mask: polygons of (x, y) in pixels, without holes; none around nothing.

    Raises
    ------
    ValueError
        If the runs don't fill the picture.
    """
    height, width = mask.size
    runs = _expanded(mask.counts) if isinstance(mask.counts, str) else mask.counts
    if min(height, width, *runs) < 0 or sum(runs) != height * width:
        raise ValueError(WHY)
    inside = np.arange(len(runs)) % 2
    pixels = np.repeat(inside.astype(np.uint8), runs).reshape(width, height).T
    # OpenCV goes through the middle of pixels: of twice as many, so that lines of pixels have area.
    doubled = cv2.resize(pixels, None, fx=2, fy=2, interpolation=cv2.INTER_NEAREST)
    found, _ = cv2.findContours(doubled, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    return [(_smooth(one)[:, 0] / 2).tolist() for one in found]


def _smooth(outline: MatLike) -> MatLike:
    return cv2.approxPolyDP(outline, 1, closed=True) if len(outline) > MANY else outline


def _expanded(text: str) -> Sequence[int]:
    """Six bits a letter, the lowest first; from the third on, differences to the last but one."""
    runs: list[int] = []
    value = shift = 0
    for letter in text:
        bits = ord(letter) - 48
        if not 0 <= bits < 64:
            raise ValueError(WHY)
        value |= (bits & 0x1F) << shift
        shift += 5
        if bits & 0x20:
            continue
        if bits & 0x10:
            value -= 1 << shift
        runs.append(value + runs[-2] if len(runs) > 2 else value)
        value = shift = 0
    if shift:
        raise ValueError(WHY)
    return runs
