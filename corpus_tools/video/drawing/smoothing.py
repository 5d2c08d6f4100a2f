"""Smoothing jagged edges of a finished picture."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from corpus_tools.video.drawing.canvas import Image

LEAST_CONTRAST = 20
"""Of 255: weaker edges are left alone."""
LONGEST_PX = 8.0
"""How far along an edge colours are averaged, both ways together; stairs can be longer."""
ALONG = (-0.5, -1 / 6, 1 / 6, 0.5)
"""Where colours are taken on that way."""
ROW = 256
"""OpenCV looks up colours in tables whose rows are not too long, nor too many."""
BORDER = cv2.BORDER_REPLICATE


def smoothed(picture: Image) -> Image:
    """A picture (h, w, 3) whose pixels at edges have the mean colour along their edge.

    An edge that is nearly level or upright has long stairs, and is averaged farther. Where that
    leads past the edge's end only the nearer half counts.
    """
    grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
    block = np.ones((3, 3), np.uint8)
    high, low = cv2.dilate(grey, block), cv2.erode(grey, block)
    edge = np.flatnonzero(cv2.subtract(high, low) > LEAST_CONTRAST).astype(np.int32)
    if not len(edge):
        return picture
    # The last row is filled with pixels of the first, which get the same colour twice.
    edge = np.resize(edge, (-(-len(edge) // ROW), ROW))
    x, y = (n.astype(np.float32) for n in (edge % grey.shape[1], edge // grey.shape[1]))
    across = cv2.Sobel(grey, cv2.CV_32F, 1, 0).reshape(-1)[edge]
    up = cv2.Sobel(grey, cv2.CV_32F, 0, 1).reshape(-1)[edge]
    # The edge runs square to the gradient; the shorter component becomes a pixel long.
    slowest = np.maximum(np.minimum(np.abs(across), np.abs(up)), 1)
    limit = LONGEST_PX / np.maximum(cv2.magnitude(across, up), 1)
    length = np.minimum(2 / slowest, limit)
    way_x, way_y = -up * length, across * length
    colours = [
        cv2.remap(picture, x + s * way_x, y + s * way_y, cv2.INTER_LINEAR, borderMode=BORDER)
        for s in ALONG
    ]
    near = _mean(colours[1], colours[2])
    mean = _mean(near, _mean(colours[0], colours[3]))
    grey_mean = cv2.cvtColor(mean, cv2.COLOR_RGB2GRAY)
    beyond = (grey_mean < low.reshape(-1)[edge]) | (grey_mean > high.reshape(-1)[edge])
    mean[beyond] = near[beyond]
    result: Image = picture.copy()
    result.reshape(-1, 3)[edge] = mean
    return result


def _mean(one: npt.NDArray[Any], other: npt.NDArray[Any]) -> Image:
    return np.asarray(cv2.addWeighted(one, 0.5, other, 0.5, 0), np.uint8)
