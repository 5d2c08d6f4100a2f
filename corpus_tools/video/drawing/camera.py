"""Cameras: their poses, and the part of the world in the picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from corpus_tools.world.state.recording import Recording, heading
from corpus_tools.world.state.shapes import shape_of
from corpus_tools.world.state.solids import extents
from corpus_tools.world.state.thing_kinds import PERSON, Kind, kind_of
from g3.geometry.plane import BoolArray, rotate
from g3.groundings import FloatArray
from g3.short_repr import short_repr

UP = np.array([0.0, 0.0, 1.0])


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """A pinhole camera that is not rolled."""

    position: FloatArray
    """Shape (3,), metres."""
    target: FloatArray
    """A point in the middle of the picture, shape (3,)."""
    fovy: float
    """Angle from the bottom to the top of the picture, radians."""

    @property
    def axes(self) -> FloatArray:
        """Unit vectors to the right, down and ahead, shape (3, 3): rows rotate into its frame."""
        ahead = self.target - self.position
        ahead = ahead / np.linalg.norm(ahead)
        right = np.cross(ahead, UP)
        right /= np.linalg.norm(right)
        return np.stack((right, np.cross(ahead, right), ahead))

    def intrinsics(self, size: tuple[int, int]) -> FloatArray:
        """Return the matrix K, shape (3, 3), of pictures of a size (width, height) in pixels.

        Pixels count to the right and down; (0, 0) is the upper left corner of the picture.
        """
        focal = size[1] / 2 / math.tan(self.fovy / 2)
        return np.array([[focal, 0, size[0] / 2], [0, focal, size[1] / 2], [0, 0, 1]])

    def extrinsics(self) -> FloatArray:
        """Return the matrix [R | t], shape (3, 4), from the world's frame to the camera's."""
        rotation = self.axes
        return np.concatenate((rotation, -(rotation @ self.position)[:, None]), axis=1)

    def project(self, points: FloatArray, size: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
        """Return pixels (n, 2) of points (n, 3), and their distances ahead of the camera (n,)."""
        local = (points - self.position) @ self.axes.T
        depth = local[:, 2]
        focal = size[1] / 2 / math.tan(self.fovy / 2)
        xy = local[:, :2] / np.maximum(depth, 1e-6)[:, None] * focal
        return xy + np.array(size) / 2, depth


ELEVATION = math.radians(33)
MARGIN = 0.04
"""Free space along the picture's edges, as a share of its width and height."""
AROUND_M = 1.0
"""Least distance around its subject that the picture shows, in metres."""
NEAR_M = 4.0
"""Distance from the motion within which standing things are in the picture, too, in metres."""
OVERVIEW_FOVY = math.radians(38)
MOST_ROUNDS = 4
"""Largest number of times that the picture grows for things that its edge would cut off."""

TURNS_DEG = (0, -15, 15, -30, 30, -45, 45)
"""Turns of an overview to the left of where the robot looks at the start."""
TURN_COST = 0.2
"""Loss of a sideward view, of 1, for which a turn by a radian is left out."""
HIDDEN_COST = 1.0
"""Loss of a view in which nothing is seen in the end of what was moved."""
SURFACE_M = 0.05
"""Distance from a thing within which nothing hides it, in metres."""
LIFT_M = 1e-4
"""Least change of a thing's height, from one moment to the next, that is a lift, in metres."""
LOOK_AGAIN_S = 0.5


class _Scope(NamedTuple):
    """A part of the world around the robot at a moment."""

    before_s: float
    """Time for which the robot's way so far is in the picture, in seconds."""
    after_s: float
    """Time for which its way ahead is."""
    around_m: float
    """Least distance around that way, in metres."""
    beside_m: float
    """Distance from the robot's middle to the box of things that are in it, whole."""
    named_m: float
    """The same for things that move or that steps name."""
    share: float
    """Part of the picture's width from which on the robot is large enough; 0 if it is only a
    choice where there is no other."""


SCOPES = (
    _Scope(1.0, 3.0, 1.2, 1.6, 3.0, 0.21),
    _Scope(0.5, 1.5, 0.8, 1.6, 3.0, 0.21),
    _Scope(0.5, 1.5, 0.4, 1.6, 2.0, 0.21),
    _Scope(0.3, 0.8, 0.1, 1.6, 1.6, 0.195),
    _Scope(0.2, 0.5, 0.1, 1.2, 1.2, 0.0),
)
"""Choices of :func:`track`: those in which the robot is large enough, preferably the first."""
LEAST_SHARE = 0.2
"""Part of it to which the robot may shrink where the camera draws back from things that are cut."""
STEADY = math.radians(20)
"""Least turn within the time of smoothing where it doesn't draw back."""
SMALLEST, BACKWARDS = 1.25, 5
"""Most that it may shrink, as a ratio, and number of distances that are compared."""
ASIDE = np.array(list(product(np.linspace(-1.0, 1.0, 5), np.linspace(-1.0, 1.0, 7))))
"""Compared positions across and down, as parts of the room that there is to both sides."""
ASIDE_LOSS, BACK_LOSS, LEAP_LOSS = 0.1, 3.0, 0.3
"""Losses for being at the end of that room, for each ratio, and for a leap, by square metres."""
VIEWS, STEP_M = 100, 0.6
"""Number of positions that are kept of each time, and length of a step that is no leap, in metres:
of as long a way as the robot goes from one time to the next."""
SCOPE_LOSS = 0.1
"""Loss for each scope in which the robot is larger than in the first one that is large enough."""
PERSON_LOSS, DECK_LOSS, OTHER_LOSS = 1.0, 0.6, 0.03
"""Losses for people, trucks and trailers, and other things that the picture's edge cuts."""
EDGE = 0.02
"""Part of the picture's half within which things that are whole aren't quite sure to be."""
SMOOTH_S = 2.0
"""Time over which its movement is smoothed, in seconds."""
OPENING_S = 2.0
"""Time for which everything is seen first, in seconds; for as long it draws near."""


def overview(recording: Recording, size: tuple[int, int]) -> list[Camera]:
    """Return a fixed camera high behind the robot's start that sees all that happens.

    The picture has the moving things, those that steps name, and those near them. The camera
    looks as the robot does at the start, so that left and right are the robot's.
    """
    ahead = _looking(recording)
    points = _extent(recording)
    others = [_corners(recording, i) for i in range(len(recording.start.objects))]
    camera = _framing(_padded(points, AROUND_M), ahead, size)
    # What the picture's edge would cut off is shown whole.
    for _ in range(MOST_ROUNDS):
        cut = [corners for corners in others if _is_cut(camera, corners, size)]
        if not cut:
            break
        points = np.concatenate((points, *cut))
        camera = _framing(_padded(points, AROUND_M), ahead, size)
    return [camera]


def track(recording: Recording, size: tuple[int, int]) -> list[Camera]:
    """Return a camera that begins as :func:`overview` and then keeps near the motion.

    It looks the same way all the time, and moves slowly: what the robot passes in the next
    seconds, and what stands beside it, is in the picture.
    """
    ahead, t = _looking(recording), recording.t_s
    (whole,) = overview(recording, size)
    still = recording.position[0]
    robot, moved = _robot(recording), (recording.position != still).any(axis=(0, 2))
    named = _named(recording)
    wide = [i for i, item in enumerate(recording.start.objects) if moved[i] or item.id in named]
    centres = np.arange(0.0, t[-1] + LOOK_AGAIN_S, LOOK_AGAIN_S)
    views, losses = [], []
    corners_of = _Corners(recording)
    yaw = np.unwrap(heading(recording.orientation[:, robot]))
    kinds = [kind_of(item.labels) for item in recording.start.objects]
    cut_losses = np.array([_loss_of_cutting(kind) for kind in kinds])
    for centre in centres:
        now = _window(t, centre, centre)
        things = [corners_of(i, now) for i in range(len(moved))]
        turns = yaw[_window(t, centre - SMOOTH_S / 2, centre + SMOOTH_S / 2)]
        is_steady = bool(np.ptp(turns) < STEADY)  # else the robot may be seen narrower soon
        here: list[FloatArray] = []
        loss: list[FloatArray] = []
        for scope in SCOPES:
            if here and not scope.share:
                continue
            window = _window(t, centre - scope.before_s, centre + scope.after_s)
            way = recording.position[window, robot]
            points = [_padded(corners_of(robot, window), scope.around_m)]
            for i in range(len(moved)):
                corners = corners_of(i, window)
                reach = scope.named_m if i in wide else scope.beside_m
                if i != robot and _gap(way, corners) < reach:
                    points.append(corners)
            camera = _framing(np.concatenate(points), ahead, size)
            pixels, robot_m = camera.project(things[robot], size)
            share = float(np.ptp(pixels[:, 0])) / size[0]
            if share < scope.share:
                continue
            farthest = max(share / LEAST_SHARE, 1.0) if is_steady else 1.0
            seen = _views(np.concatenate(points), camera, float(robot_m.mean()), farthest, size)
            cut = _cuts(things, camera, seen.aside, size) @ cut_losses
            here.append(camera.position + seen.aside @ camera.axes)
            loss.append(seen.losses + cut + SCOPE_LOSS * len(here))
        least = np.argsort(np.concatenate(loss), kind="stable")[:VIEWS]
        views.append(np.concatenate(here)[least])
        losses.append(np.concatenate(loss)[least])
    near = _steadiest(views, losses)
    path = np.stack([np.interp(t, centres, column) for column in near.T], axis=1)
    path = _smooth(t, path, seconds=SMOOTH_S)
    start = np.clip((t - OPENING_S) / OPENING_S, 0.0, 1.0)
    nearer = (start * start * (3 - 2 * start))[:, None]
    path = whole.position * (1 - nearer) + path * nearer
    return [Camera(position, position + ahead, OVERVIEW_FOVY) for position in path]


def follow(recording: Recording, size: tuple[int, int]) -> list[Camera]:
    """Return a camera that is drawn along behind the robot, and looks over it."""
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
    """Return a camera in the driver's seat that looks ahead and down at the forks."""
    del size
    robot = _robot(recording)
    yaw = heading(recording.orientation[:, robot])
    ahead = np.stack((np.cos(yaw), np.sin(yaw)), axis=1)
    eye = recording.position[:, robot] + np.concatenate(
        (SEAT[0] * ahead, np.full((len(yaw), 1), SEAT[2])), axis=1
    )
    sight = np.concatenate((ahead, np.full((len(yaw), 1), -0.22)), axis=1)
    return [Camera(e, e + d, math.radians(62)) for e, d in zip(eye, sight, strict=True)]


CAMERAS = MappingProxyType(
    {"overview": overview, "track": track, "follow": follow, "operator": operator}
)


def _robot(recording: Recording) -> int:
    return [item.id for item in recording.start.objects].index(recording.start.agent_id)


def _floor(recording: Recording) -> float:
    """Return the height of the ground, on which the robot stands."""
    return recording.start.objects[_robot(recording)].prism.z_min


def _looking(recording: Recording) -> FloatArray:
    """Return a direction down and to where the robot looks at the start, or aside, shape (3,).

    It is turned so far that lifts, or ways without any, are seen from their side, and that nothing
    hides what was moved. Left stays left.
    """
    yaw = heading(recording.orientation[:, _robot(recording)])
    turns = np.radians(TURNS_DEG)
    views = np.stack([_downwards(float(yaw[0] + turn)) for turn in turns])
    sides = np.abs(np.sin(yaw[_lifts(recording)] - yaw[0] - turns[:, None])).mean(axis=1)
    hidden = np.array([_hidden_share(recording, view) for view in views])
    best = np.argmax(sides - TURN_COST * np.abs(turns) - HIDDEN_COST * hidden)
    ahead: FloatArray = views[best]
    return ahead


def _downwards(yaw: float) -> FloatArray:
    level = math.cos(ELEVATION)
    return np.array([level * math.cos(yaw), level * math.sin(yaw), -math.sin(ELEVATION)])


def _hidden_share(recording: Recording, ahead: FloatArray) -> float:
    """Return the part of the moved loads that other things hide in the end from a far camera."""
    objects, end = recording.start.objects, slice(len(recording.t_ns) - 1, len(recording.t_ns))
    moved = (recording.position[-1] != recording.position[0]).any(axis=-1)
    hidden: list[bool] = []
    for load in np.flatnonzero(moved).tolist():
        if kind_of(objects[load].labels).carriable:
            points = _placed(recording, load, end)
            points = np.concatenate((points, points.mean(axis=0, keepdims=True)))
            others = [i for i in range(len(objects)) if i != load]
            covers = [_is_behind(recording, i, points, ahead) for i in others]
            hidden += np.any(covers, axis=0).tolist()
    return float(np.mean(hidden)) if hidden else 0.0


def _is_behind(recording: Recording, i: int, points: FloatArray, ahead: FloatArray) -> BoolArray:
    """Check which points (n, 3) a thing hides in the end from a far camera that looks ahead."""
    item, place = recording.start.objects[i], recording.position[-1, i]
    turn = -heading(recording.orientation[-1, i])
    towards = np.array([*rotate(-ahead[:2], turn), -ahead[2]])
    local = points - place
    local[:, :2] = rotate(local[:, :2], np.full(len(local), turn))
    ground = _floor(recording) - float(place[2])
    behind = np.zeros(len(points), dtype=bool)
    for extent in extents(kind_of(item.labels), shape_of(item), ground):
        faces = (np.array(extent).T[:, None] - local) / np.where(towards == 0, 1e-12, towards)
        enters, leaves = faces.min(axis=0).max(axis=1), faces.max(axis=0).min(axis=1)
        behind |= leaves > np.maximum(enters, SURFACE_M)
    return behind


def _lifts(recording: Recording) -> npt.NDArray[np.intp]:
    """Return the indices of moments in which a thing goes up or down; of all if none does."""
    height = recording.position[..., 2]
    moments = np.flatnonzero((np.abs(np.diff(height, axis=0)) > LIFT_M).any(axis=1))
    return moments if len(moments) else np.arange(len(height))


def _window(t: FloatArray, first_s: float, last_s: float) -> slice:
    """Return the indices of the moments between two times, or of the next one, or the last."""
    first, last = np.searchsorted(t, (first_s, last_s)).tolist()
    first = min(first, len(t) - 1)
    return slice(first, max(last, first + 1))


def _padded(points: FloatArray, around_m: float) -> FloatArray:
    """Return the corners of level squares around points (n, 3), shape (4 n, 3)."""
    around = np.array([[x, y, 0.0] for x in (-around_m, around_m) for y in (-around_m, around_m)])
    padded: FloatArray = (points[:, None] + around).reshape(-1, 3)
    return padded


def _framing(points: FloatArray, ahead: FloatArray, size: tuple[int, int]) -> Camera:
    """Return the nearest camera ahead of all points (n, 3)."""
    unit = Camera(np.zeros(3), ahead, OVERVIEW_FOVY)
    local = points @ unit.axes.T
    slope_y = math.tan(OVERVIEW_FOVY / 2) * (1 - 2 * MARGIN)
    slope_x = slope_y * size[0] / size[1]
    z = min(_apex(local[:, 0], local[:, 2], slope_x), _apex(local[:, 1], local[:, 2], slope_y))
    depth = local[:, 2] - z
    position = np.array([*(_middle(local[:, i], depth) for i in range(2)), z]) @ unit.axes
    return Camera(position, position + ahead, OVERVIEW_FOVY)


class _Views(NamedTuple):
    """Positions of a camera from which all that it has to show is in the picture."""

    aside: FloatArray
    """How far they are right of, below and ahead of a camera's, in metres, shape (n, 3)."""
    losses: FloatArray
    """Losses for being far from the middle, or farther back than need be, shape (n,)."""


def _views(
    points: FloatArray, camera: Camera, robot_m: float, farthest: float, size: tuple[int, int]
) -> _Views:
    """Return positions that show points (n, 3), as near as a camera or farther back.

    `robot_m` is the robot's distance. `farthest` is how much smaller it may become.
    """
    local = (points - camera.position) @ camera.axes.T
    slope_y = math.tan(OVERVIEW_FOVY / 2) * (1 - 2 * MARGIN)
    slopes = np.array([slope_y * size[0] / size[1], slope_y])
    smaller = np.linspace(1.0, min(farthest, SMALLEST), BACKWARDS)[:, None]
    back = (smaller - 1.0) * robot_m
    reach = slopes * (local[:, 2:] + back[..., None])
    low, high = (local[:, :2] - reach).max(axis=1), (local[:, :2] + reach).min(axis=1)
    middle, half = (low + high)[:, None] / 2, np.maximum(high - low, 0.0)[:, None] / 2
    aside = np.concatenate(
        (middle + half * ASIDE, np.broadcast_to(-back[:, None], (BACKWARDS, len(ASIDE), 1))), axis=2
    )
    losses = ASIDE_LOSS * (ASIDE**2).sum(axis=1) + BACK_LOSS * (smaller - 1.0)
    return _Views(aside.reshape(-1, 3), losses.ravel())


def _cuts(
    things: Sequence[FloatArray], camera: Camera, aside: FloatArray, size: tuple[int, int]
) -> BoolArray:
    """Check which things the picture's edge cuts, from n positions aside of a camera.

    Things are corners, each (k, 3). The result has the shape (n, things).
    """
    local = (np.concatenate(things) - camera.position) @ camera.axes.T
    ahead = local[:, 2] - aside[:, 2:]
    focal = size[1] / 2 / math.tan(camera.fovy / 2)
    edge = np.array(size) / 2 * (1 - EDGE)
    pixels = (local[:, :2] - aside[:, None, :2]) * (focal / np.maximum(ahead, 1e-6))[..., None]
    first = np.cumsum([0, *map(len, things[:-1])])
    low, high = np.minimum.reduceat(pixels, first, 1), np.maximum.reduceat(pixels, first, 1)
    is_whole = ((low >= -edge) & (high <= edge)).all(axis=2)
    is_out = ((high <= -edge) | (low >= edge)).any(axis=2)
    return ~(is_whole | is_out | (np.minimum.reduceat(ahead, first, 1) <= 0))


def _loss_of_cutting(kind: Kind) -> float:
    """Return the loss for a thing of a kind that the picture's edge cuts."""
    if kind.name == PERSON.name:
        return PERSON_LOSS
    return OTHER_LOSS if kind.deck is None else DECK_LOSS


def _steadiest(positions: Sequence[FloatArray], losses: Sequence[FloatArray]) -> FloatArray:
    """Return one of the positions (n, 3) for each time: a way of little loss, without leaps.

    Losses have the shape (n,). A leap is a step farther than the robot goes meanwhile.
    """
    total, before = losses[0], []
    for last, here, loss in zip(positions, positions[1:], losses[1:], strict=False):
        leaps = np.linalg.norm(here[:, None] - last, axis=2)
        through = total + LEAP_LOSS * np.maximum(leaps - STEP_M, 0.0) ** 2
        before.append(through.argmin(axis=1))
        total = loss + through.min(axis=1)
    chosen = [int(total.argmin())]
    for back in reversed(before):
        chosen.append(int(back[chosen[-1]]))
    return np.stack([of[i] for of, i in zip(positions, reversed(chosen), strict=True)])


def _is_cut(camera: Camera, corners: FloatArray, size: tuple[int, int]) -> bool:
    """Check whether a part of a thing is in the picture, and another part isn't."""
    pixels, depth = camera.project(corners, size)
    seen = ((pixels >= 0) & (pixels <= size)).all(axis=1) & (depth > 0)
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    touches = bool((depth > 0).all() and (high > 0).all() and (low < size).all())
    return touches and not seen.all()


def _extent(recording: Recording) -> FloatArray:
    """Return corners (n, 3) of moving things, of those that steps name, and of those near them.

    If nothing moves and there are no steps, of everything.
    """
    start = recording.start
    named = {start.agent_id, *_named(recording)}
    moves = (recording.position != recording.position[0]).any(axis=(0, 2))
    nothing_happens = not (moves.any() or recording.steps)
    shown = [
        _corners(recording, i)
        for i, item in enumerate(start.objects)
        if moves[i] or item.id in named or nothing_happens
    ]
    for place in start.places:
        if place.name in named or nothing_happens:
            xy = place.prism.xy
            shown.append(np.concatenate((xy, np.full((len(xy), 1), place.prism.z_min)), axis=1))
    low, high = np.concatenate(shown).min(axis=0), np.concatenate(shown).max(axis=0)
    for i in range(len(start.objects)):
        corners = _corners(recording, i)
        gap = np.maximum(low - corners.max(axis=0), corners.min(axis=0) - high)
        if gap[:2].max() < NEAR_M:
            shown.append(corners)
    return np.concatenate(shown)


def _gap(way: FloatArray, corners: FloatArray) -> float:
    """Return the least level distance of a way (n, 3) from the upright box around corners."""
    low, high = corners[:, :2].min(axis=0), corners[:, :2].max(axis=0)
    beyond = np.maximum(np.maximum(low - way[:, :2], way[:, :2] - high), 0.0)
    return float(np.linalg.norm(beyond, axis=1).min())


def _named(recording: Recording) -> set[str]:
    """Return the values of the steps' arguments, such as ids of objects and places."""
    return {value for step in recording.steps for _, value in step.arguments}


def _corners(recording: Recording, i: int) -> FloatArray:
    """Return the corners of an object's box at moments from the first to the last, shape (n, 3)."""
    return _placed(recording, i, slice(0, len(recording.t_ns)))


class _Corners:
    """Corners of objects at the moments of windows; those of still ones are kept."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        poses = np.concatenate((recording.position, recording.orientation), axis=2)
        self._is_still = (poses == poses[0]).all(axis=(0, 2))
        self._kept: dict[int, FloatArray] = {}

    def __call__(self, i: int, window: slice) -> FloatArray:
        """Return the corners of an object at moments of a window, shape (n, 3)."""
        if not self._is_still[i]:
            return _placed(self._recording, i, window)
        if i not in self._kept:
            self._kept[i] = _placed(self._recording, i, slice(0, 1))
        return self._kept[i]


def _placed(recording: Recording, i: int, window: slice) -> FloatArray:
    """Repeat a pose from the first to the last moment of a window."""
    last = min(window.stop, len(recording.t_ns)) - 1
    moments = np.unique(np.linspace(min(window.start, last), last, 50).astype(int))
    item, poses = recording.start.objects[i], recording.position[moments, i]
    shape = shape_of(item)
    if (poses == poses[0]).all():
        moments, poses = moments[:1], poses[:1]
    yaw = heading(recording.orientation[moments, i])
    ground = _floor(recording) - float(recording.position[0, i, 2])
    boxes = np.array(extents(kind_of(item.labels), shape, ground))
    corners = np.concatenate(
        [np.stack(np.meshgrid(*box, indexing="ij"), axis=-1).reshape(8, 3) for box in boxes]
    )
    n = len(corners)
    xy = rotate(corners[None, :, :2], np.repeat(yaw[:, None], n, axis=1))
    z = np.broadcast_to(corners[None, :, 2:], (len(yaw), n, 1))
    placed: FloatArray = (np.concatenate((xy, z), axis=-1) + poses[:, None]).reshape(-1, 3)
    return placed


def _apex(x: FloatArray, z: FloatArray, slope: float) -> float:
    """Return the greatest z0 with all points in view: |x - x0| <= slope (z - z0) for some x0."""
    right = float((x - slope * z).max())
    left = float((x + slope * z).min())
    return (left - right) / (2 * slope)


def _middle(x: FloatArray, depth: FloatArray) -> float:
    """Return the x0 from which the outermost points x / depth are equally far to both sides."""
    low, high = float(x.min()), float(x.max())
    for _ in range(60):
        middle = (low + high) / 2
        seen = (x - middle) / depth
        low, high = (middle, high) if seen.max() + seen.min() > 0 else (low, middle)
    return (low + high) / 2


def _smooth(t: FloatArray, values: FloatArray, seconds: float) -> FloatArray:
    """Return values (n, ...) averaged over a window of time, with the ends held."""
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
