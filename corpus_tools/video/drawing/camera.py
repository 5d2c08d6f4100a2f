"""Where the camera stands."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from corpus_tools.world.state.recording import Recording, heading
from corpus_tools.world.state.shapes import shape_of
from g3.geometry.plane import rotate
from g3.groundings import FloatArray
from g3.short_repr import short_repr

UP = np.array([0.0, 0.0, 1.0])


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """A pinhole camera that is not rolled.

    Parameters
    ----------
    position
        Shape (3,), metres.
    target
        A point in the middle of the picture, shape (3,).
    fovy
        Angle from the bottom to the top of the picture, radians.
    """

    position: FloatArray
    target: FloatArray
    fovy: float

    @property
    def axes(self) -> FloatArray:
        """Unit vectors to the right, down and ahead, shape (3, 3): rows rotate into its frame."""
        ahead = self.target - self.position
        ahead = ahead / np.linalg.norm(ahead)
        right = np.cross(ahead, UP)
        right /= np.linalg.norm(right)
        return np.stack((right, np.cross(ahead, right), ahead))

    def intrinsics(self, size: tuple[int, int]) -> FloatArray:
        """The matrix K, shape (3, 3), of pictures of a size (width, height) in pixels.

        Pixels count to the right and down; (0, 0) is the upper left corner of the picture.
        """
        focal = size[1] / 2 / math.tan(self.fovy / 2)
        return np.array([[focal, 0, size[0] / 2], [0, focal, size[1] / 2], [0, 0, 1]])

    def extrinsics(self) -> FloatArray:
        """The matrix [R | t], shape (3, 4), from the world's frame to the camera's."""
        rotation = self.axes
        return np.concatenate((rotation, -(rotation @ self.position)[:, None]), axis=1)

    def project(self, points: FloatArray, size: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
        """Pixels (n, 2) of points (n, 3), and how far ahead of the camera they are (n,)."""
        local = (points - self.position) @ self.axes.T
        depth = local[:, 2]
        focal = size[1] / 2 / math.tan(self.fovy / 2)
        xy = local[:, :2] / np.maximum(depth, 1e-6)[:, None] * focal
        return xy + np.array(size) / 2, depth


ELEVATION = math.radians(33)
MARGIN = 0.04
"""What stays free along the picture's edges, as a part of its width and height."""
AROUND_M = 1.0
"""How far around what it shows the picture reaches at least."""
NEAR_M = 6.0
"""What stands so near to what happens is in the picture, too."""
OVERVIEW_FOVY = math.radians(38)


def overview(recording: Recording, size: tuple[int, int]) -> list[Camera]:
    """A fixed camera high behind the robot's start that sees all that happens.

    What moves, what the steps name and what stands near that is in the picture. The camera
    looks as the robot does at the start, so that left and right are the robot's.
    """
    points = _extent(recording)
    yaw = float(heading(recording.orientation[0, _robot(recording)]))
    ahead = np.array(
        [*(math.cos(ELEVATION) * np.array([math.cos(yaw), math.sin(yaw)])), -math.sin(ELEVATION)]
    )
    unit = Camera(np.zeros(3), ahead, OVERVIEW_FOVY)
    around = np.array([[x, y, 0.0] for x in (-AROUND_M, AROUND_M) for y in (-AROUND_M, AROUND_M)])
    local = (points[:, None] + around).reshape(-1, 3) @ unit.axes.T
    slope_y = math.tan(OVERVIEW_FOVY / 2) * (1 - 2 * MARGIN)
    slope_x = slope_y * size[0] / size[1]
    z = min(_apex(local[:, 0], local[:, 2], slope_x), _apex(local[:, 1], local[:, 2], slope_y))
    depth = local[:, 2] - z
    position = np.array([*(_middle(local[:, i], depth) for i in range(2)), z]) @ unit.axes
    return [Camera(position, position + ahead, OVERVIEW_FOVY)]


def follow(recording: Recording, size: tuple[int, int]) -> list[Camera]:
    """A camera that is drawn along behind the robot, and looks over it."""
    del size
    robot = _robot(recording)
    position = recording.position[:, robot]
    yaw = np.unwrap(heading(recording.orientation[:, robot]))
    t = recording.t_s
    behind = _smooth(t, yaw, seconds=1.2)
    middle = _smooth(t, position, seconds=0.5)
    direction = np.stack((np.cos(behind), np.sin(behind), np.zeros_like(behind)), axis=1)
    eye = middle - 5.6 * direction + [0, 0, 3.9]
    target = middle + 2.4 * direction + [0, 0, 0.5]
    return [Camera(e, p, math.radians(52)) for e, p in zip(eye, target, strict=True)]


SEAT = (-0.55, 0.0, 1.66)
"""The driver's eyes in the robot's frame: where a driver's head is."""


def operator(recording: Recording, size: tuple[int, int]) -> list[Camera]:
    """What the driver sees from the seat, looking ahead and down at the forks."""
    del size
    robot = _robot(recording)
    yaw = heading(recording.orientation[:, robot])
    ahead = np.stack((np.cos(yaw), np.sin(yaw)), axis=1)
    eye = recording.position[:, robot] + np.concatenate(
        (SEAT[0] * ahead, np.full((len(yaw), 1), SEAT[2])), axis=1
    )
    look = np.concatenate((ahead, np.full((len(yaw), 1), -0.22)), axis=1)
    return [Camera(e, e + d, math.radians(62)) for e, d in zip(eye, look, strict=True)]


CAMERAS = MappingProxyType({"overview": overview, "follow": follow, "operator": operator})


def _robot(recording: Recording) -> int:
    return [item.id for item in recording.start.objects].index(recording.start.agent_id)


def _extent(recording: Recording) -> FloatArray:
    """Corners of all that moves, at any moment, of what steps name, and of what is near that.

    Where nothing moves and there are no steps, of everything.

    Returns
    -------
    FloatArray
        Shape (n, 3).
    """
    start = recording.start
    named = {start.agent_id, *(value for step in recording.steps for _, value in step.arguments)}
    moves = (recording.position != recording.position[0]).any(axis=(0, 2))
    shown = [
        _corners(recording, i)
        for i, item in enumerate(start.objects)
        if moves[i] or item.id in named or not (moves.any() or recording.steps)
    ]
    for place in start.places:
        if place.name in named:
            xy = place.prism.xy
            shown.append(np.concatenate((xy, np.full((len(xy), 1), place.prism.z_min)), axis=1))
    low, high = np.concatenate(shown).min(axis=0), np.concatenate(shown).max(axis=0)
    for i in range(len(start.objects)):
        corners = _corners(recording, i)
        gap = np.maximum(low - corners.max(axis=0), corners.min(axis=0) - high)
        if gap[:2].max() < NEAR_M:
            shown.append(corners)
    return np.concatenate(shown)


def _corners(recording: Recording, i: int) -> FloatArray:
    """Corners of an object's box at moments from the first to the last, shape (n, 3)."""
    moments = np.unique(np.linspace(0, len(recording.t_ns) - 1, 50).astype(int))
    shape, poses = shape_of(recording.start.objects[i]), recording.position[moments, i]
    if (poses == poses[0]).all():
        moments, poses = moments[:1], poses[:1]
    yaw = heading(recording.orientation[moments, i])
    edges = np.stack((shape.low, shape.high), axis=1)
    box = np.stack(np.meshgrid(*edges, indexing="ij"), axis=-1).reshape(8, 3)
    xy = rotate(box[None, :, :2], np.repeat(yaw[:, None], 8, axis=1))
    z = np.broadcast_to(box[None, :, 2:], (len(yaw), 8, 1))
    placed: FloatArray = (np.concatenate((xy, z), axis=-1) + poses[:, None]).reshape(-1, 3)
    return placed


def _apex(x: FloatArray, z: FloatArray, slope: float) -> float:
    """The greatest z0 from which all points are in view: |x - x0| <= slope (z - z0) for some x0."""
    right = float((x - slope * z).max())
    left = float((x + slope * z).min())
    return (left - right) / (2 * slope)


def _middle(x: FloatArray, depth: FloatArray) -> float:
    """The x0 from which the outermost points x / depth are equally far to both sides."""
    low, high = float(x.min()), float(x.max())
    for _ in range(60):
        middle = (low + high) / 2
        seen = (x - middle) / depth
        low, high = (middle, high) if seen.max() + seen.min() > 0 else (low, middle)
    return (low + high) / 2


def _smooth(t: FloatArray, values: FloatArray, seconds: float) -> FloatArray:
    """Values (n, ...) averaged over a window of time, with the ends held."""
    n = len(t)
    if n < 3:
        return values
    step = (t[-1] - t[0]) / (n - 1)
    half = max(1, round(seconds / step))
    window = np.hanning(2 * half + 3)[1:-1]
    window /= window.sum()
    flat = values.reshape(n, -1)
    padded = np.concatenate((np.repeat(flat[:1], half, 0), flat, np.repeat(flat[-1:], half, 0)))
    columns = [np.convolve(column, window, mode="valid") for column in padded.T]
    return np.stack(columns, axis=1).reshape(values.shape)
