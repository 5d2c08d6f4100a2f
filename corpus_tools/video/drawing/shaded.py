"""Frames of a camera that moves: all is drawn in the sun, and then shadows are darkened.

How much light is left in the shadow follows from how a surface lies to the sun, which the
depths show: one drawing is enough. Edges are smoothed in the finished picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from corpus_tools.video.drawing.camera import Camera
from corpus_tools.video.drawing.canvas import MOVING, Canvas, Depth, Image
from corpus_tools.video.drawing.shadows import (
    Float32Array,
    ShadowMap,
    Shadows,
    covering,
    places,
    shade,
    with_shadow,
)
from corpus_tools.world.physics.build import ground_of
from corpus_tools.world.state.recording import Recording
from g3.groundings import FloatArray

TEXEL_M, MOVING_TEXEL_M = 0.015, 0.004
"""Edges of texels in shadow maps, in metres: moving things are near the camera."""
BEHIND_M = 0.015
"""Least distance behind a thing in its shade, in metres: else grazing light leaves speckles."""
SOFT = 3
"""Width of shadows' edges, pixels."""
ROWS = 1.5
"""Rows that are drawn for each of a frame's: thin level lines on the ground need them."""
TURNED, RAISED_M = 0.0015, 0.004
"""From which difference of a quaternion's component, or of the forks' height, shadows change."""


class Shaded:
    """Frames of a recording, each with its own camera.

    The canvas has the recording's world and its moving objects, and a sun; the recording is sampled
    at the video's frames. `size` is the width and height of a frame.
    """

    def __init__(
        self,
        canvas: Canvas,
        recording: Recording,
        cameras: Sequence[Camera],
        size: tuple[int, int],
    ) -> None:
        self._canvas, self._recording, self._cameras, self._size = canvas, recording, cameras, size
        self._ground = ground_of(recording.start)
        canvas.show(recording, 0)
        canvas.draw(cameras[0], size)
        self._clip = canvas.clip()
        self._rows = ((np.arange(size[1]) + 0.5) * ROWS).astype(int)
        self._shadows = Shadows(canvas, TEXEL_M)
        self._share = _sunshine(canvas)
        geoms = canvas.geoms_of(MOVING)
        of = canvas.object_of_geom[geoms]
        self._geoms = {int(item): geoms[of == item] for item in np.unique(of)}
        self._cast: dict[int, tuple[int, ShadowMap]] = {}

    def frame(self, k: int) -> Image:
        """Draw the k-th frame, shape (height, width, 3), rows from the top down."""
        canvas, camera = self._canvas, self._cameras[k]
        canvas.show(self._recording, k)
        canvas.draw(camera, self._size, rows=ROWS)
        fine, depth = canvas.pixels(), canvas.depth()[self._rows]
        picture = np.asarray(cv2.resize(fine, self._size, interpolation=cv2.INTER_AREA), np.uint8)
        nearness = _nearness(depth, self._clip)
        rays, eye = places(camera, self._size, self._shadows.axes)
        sun = self._sun(k, rays / nearness + eye)
        x, y, width, height = cv2.boundingRect(cv2.bitwise_not(sun))
        here = slice(y, y + height), slice(x, x + width)
        if width:
            share = _share_of_sun(nearness, camera, self._shadows.axes[2], self._share, here)
            shadow = cv2.bitwise_not(cv2.merge((sun[here],) * 3))
            picture[here] = _without(picture[here], _product(share, shadow))
        return smoothed(np.ascontiguousarray(picture[::-1]))

    def _sun(self, k: int, place: Float32Array) -> Image:
        """Return the sun's share at places, as :func:`shade` gives it."""
        still, lamp_m = self._shadows.still, self._shadows.lamp_m
        if still is None:
            sun = np.full(place.shape[1:], 255, np.uint8)
        else:
            sun = shade(still, place, still.bias, SOFT, lamp_m)
        for item, geoms in self._geoms.items():
            light = self._shadows.axes[2]
            corners = with_shadow(self._canvas.corners(geoms), light, self._ground, lamp_m)
            part = covering(corners, self._cameras[k], self._size, near_m=self._clip[0])
            if part is None:
                continue
            map_, shift = self._casting(item, k)
            here = part.slices
            behind = max(map_.bias, BEHIND_M) + shift
            sunny = shade(map_, place[:, here[0], here[1]], behind, SOFT, lamp_m)
            sun[here] = np.minimum(sun[here], sunny)
        return sun

    def _casting(self, item: int, k: int) -> tuple[ShadowMap, float]:
        """Return the shadow map of a moving object, and its shift along the sunlight.

        An object that has not turned since it was drawn last isn't drawn again.
        """
        if item not in self._cast or self._turned(item, self._cast[item][0], k):
            corners = self._canvas.corners(self._geoms[item])
            self._cast[item] = k, self._shadows.moving_alone(corners, MOVING_TEXEL_M)
        drawn, map_ = self._cast[item]
        position = self._recording.position
        u, v, d = self._shadows.axes @ (position[k, item] - position[drawn, item])
        first = (map_.first[0] + u / map_.texel, map_.first[1] + v / map_.texel)
        return replace(map_, first=first), float(d)

    def _turned(self, item: int, j: int, k: int) -> bool:
        """Check whether an object has another shape as the sun sees it, at two moments."""
        start, orientation = self._recording.start, self._recording.orientation
        height = self._recording.fork_height_m
        raised = start.objects[item].id == start.agent_id and abs(height[j] - height[k]) > RAISED_M
        return raised or bool(np.abs(orientation[j, item] - orientation[k, item]).max() > TURNED)


def _nearness(depth: Depth, clip: tuple[float, float]) -> Float32Array:
    """Return one over the distance ahead of the camera, of drawn depths."""
    near, far = clip
    result: Float32Array = np.float32(1 / near) - depth * np.float32(1 / near - 1 / far)
    return result


def _sunshine(canvas: Canvas) -> Image:
    """Return the sun's share of the light on a surface, of 255 each, shape (1, 256, 3).

    The second axis is the cosine between the surface's normal and the sun, from 0 to 1.
    The lamp at the camera counts as if it met all surfaces at 60 degrees.
    """
    model = canvas.model
    lamp = model.vis.headlight
    other = lamp.ambient + 0.5 * lamp.diffuse + model.light_ambient[canvas.sun]
    sun = np.linspace(0, 1, 256)[:, None] * model.light_diffuse[canvas.sun]
    # More light than white can be makes no difference.
    share = 1 - np.minimum(other, 1) / np.minimum(other + sun, 1)
    table: Image = np.round(255 * share).astype(np.uint8)[None]
    return table


def _share_of_sun(
    nearness: Float32Array,
    camera: Camera,
    light: FloatArray,
    share: Image,
    part: tuple[slice, slice],
) -> Image:
    """Return the sun's share of each pixel's light, of 255, in a part of the picture, (h, w, 3).

    Where a surface is flat, one over the distance ahead is linear in the picture's coordinates: its
    slopes are the surface's normal. Rows run from the bottom up. `light` is where the sunlight
    goes, shape (3,), `share` as :func:`_sunshine` gives it, `part` rows and columns.
    """
    height, width = nearness.shape
    focal = np.float32(height / 2 / np.tan(camera.fovy / 2))
    right, down, ahead = (camera.axes @ light).astype(np.float32)
    x = (np.arange(width, dtype=np.float32) + np.float32(0.5 - width / 2))[part[1]]
    y = (np.arange(height, dtype=np.float32) + np.float32(0.5 - height / 2))[part[0], None]
    nearness = nearness[part]
    slope_x, slope_y = _slope(nearness, (1, 0)), _slope(nearness, (0, 1))
    out = nearness - x * slope_x - y * slope_y
    slope_x *= focal
    slope_y *= focal
    along = slope_x * right - slope_y * down + out * ahead
    length = cv2.magnitude(cv2.magnitude(slope_x, slope_y), out)
    facing = cv2.convertScaleAbs(np.maximum(along / length, 0), alpha=255)
    # What is only a pixel wide has no slope: it gets that of what is around.
    facing = cv2.morphologyEx(facing, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    return np.asarray(cv2.LUT(cv2.merge((facing, facing, facing)), share), np.uint8)


def _product(one: npt.NDArray[Any], other: npt.NDArray[Any]) -> Image:
    """Multiply quantities that are measured in 255ths."""
    return np.asarray(cv2.multiply(one, other, scale=1 / 255), np.uint8)


def _without(picture: Image, taken: Image) -> Image:
    """Return a picture from which parts of its light, of 255, are taken."""
    return np.asarray(cv2.subtract(picture, _product(picture, taken)), np.uint8)


def _slope(values: Float32Array, step: tuple[int, int]) -> Float32Array:
    """Return the difference to the next or the last value, the nearer one: no leap at outlines."""
    x, y = step
    kernel = np.array([-1, 1], np.float32).reshape(1 + y, 1 + x)
    forth = cv2.filter2D(values, -1, kernel, anchor=(0, 0))
    back = cv2.filter2D(values, -1, kernel, anchor=(x, y))
    nearer: Float32Array = np.where(np.abs(forth) < np.abs(back), forth, back)
    return nearer


LEAST_CONTRAST = 20
"""Least contrast of an edge, of 255: weaker edges are left alone."""
LONGEST_PX = 8.0
"""Longest way along an edge over which colours are averaged, both ways together, in pixels; stairs
can be longer."""
ALONG = (-0.5, -1 / 6, 1 / 6, 0.5)
"""Positions on that way at which colours are taken."""
ROW = 256
"""OpenCV looks up colours in tables whose rows are not too long, nor too many."""
BORDER = cv2.BORDER_REPLICATE


def smoothed(picture: Image) -> Image:
    """Return a picture (h, w, 3) whose edge pixels have the mean colour along their edge.

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
