"""Ways around obstacles for a vehicle that steers, backs up, and can turn on the spot.

A search over short arcs (hybrid A* [1]_). At every turn it tries to go on to a goal directly: by a
Dubins curve, or by turning, driving straight and turning again. What it finds is then shortened
with the same curves. Everything is deterministic. Poses are rows x, y, yaw; obstacles are upright
boxes.

References
----------
.. [1] D. Dolgov, S. Thrun, M. Montemerlo, J. Diebel, "Path planning for autonomous vehicles
   in unknown semi-structured environments", IJRR 29(5), 2010.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count

import numpy as np
import numpy.typing as npt
from scipy.ndimage import map_coordinates
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from corpus_tools.world.planning import curves
from g3.actions.courses import arc
from g3.geometry.plane import rotate, wrap
from g3.groundings import FloatArray
from g3.short_repr import short_repr

_SPACING_M = 0.2
_DISTANCE_CELL_M = 0.1
_FAR = 1e3

MARGIN_M = 0.10
"""Room that the vehicle always keeps."""
COMFORT_M = 0.35
"""Room that it likes to keep, and the largest extra cost of a metre with less of it."""
COMFORT_COST = 1.5

BORDER_M = 6.0
STEP_M = 0.6
RADIUS_M = 1.5
WIDE_RADIUS_M = 2.5


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Boxes:
    """Upright boxes."""

    middle: FloatArray
    yaw: FloatArray
    half: FloatArray
    """Footprints: middles (n, 2), headings (n,), half lengths along and across (n, 2)."""
    z: FloatArray
    """Bottoms and tops above the ground, shape (n, 2)."""

    def __len__(self) -> int:
        return len(self.yaw)

    def between(self, low: float, high: float) -> Boxes:
        """Return the boxes that a thing between two heights could touch."""
        return self.where((self.z[:, 1] > low) & (self.z[:, 0] < high))

    def where(self, chosen: npt.NDArray[np.bool_]) -> Boxes:
        """Return the chosen boxes."""
        return Boxes(self.middle[chosen], self.yaw[chosen], self.half[chosen], self.z[chosen])

    def corners(self) -> FloatArray:
        """Return the corners of the footprints, shape (n, 4, 2)."""
        signs = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
        local = signs * self.half[:, None]
        corners: FloatArray = self.middle[:, None] + rotate(local, self.yaw[:, None])
        return corners


@short_repr
@dataclass(frozen=True, slots=True)
class Rect:
    """A rectangle in the robot's frame: from and to along x and y, in metres."""

    x: tuple[float, float]
    y: tuple[float, float]


def outline(rects: Sequence[Rect]) -> FloatArray:
    """Return points (m, 2) around rectangles, so dense that nothing slips between two of them."""
    return np.concatenate([_border(rect) for rect in rects])


def placed(points: FloatArray, poses: FloatArray) -> FloatArray:
    """Move points (m, 2) of the robot's frame to poses (..., 3); shape (..., m, 2)."""
    moved: FloatArray = poses[..., None, :2] + rotate(points, poses[..., None, 2])
    return moved


def distance(points: FloatArray, boxes: Boxes) -> FloatArray:
    """Return metres from points (..., 2) to the nearest box, negative inside, shape (...)."""
    nearest = np.full(points.shape[:-1], _FAR)
    for middle, yaw, half in zip(boxes.middle, boxes.yaw, boxes.half, strict=True):
        # By coordinates: numpy is slow where an axis has two elements.
        ahead, aside = np.moveaxis(np.abs(rotate(points - middle, -yaw)) - half, -1, 0)
        outside = np.hypot(np.maximum(ahead, 0), np.maximum(aside, 0))
        nearest = np.minimum(nearest, outside + np.minimum(np.maximum(ahead, aside), 0))
    return nearest


def room(poses: FloatArray, points: FloatArray, boxes: Boxes) -> FloatArray:
    """Return the room that an outline (m, 2) has at each of poses (n, 3), in metres, shape (n,)."""
    least: FloatArray = distance(placed(points, poses), boxes).min(axis=-1)
    return least


def clearance(poses: FloatArray, points: FloatArray, boxes: Boxes) -> float:
    """Return the least room that an outline (m, 2) has at poses (n, 3), in metres."""
    return float(room(poses, points, boxes).min())


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Field:
    """Distances to boxes, looked up in a grid."""

    origin: FloatArray
    """Position of the first cell, shape (2,)."""
    metres: FloatArray
    """Distances at the cells, shape (nx, ny)."""

    def at(self, points: FloatArray) -> FloatArray:
        """Return distances at points (..., 2); there is no room beyond the grid."""
        cells = np.moveaxis((points - self.origin) / _DISTANCE_CELL_M, -1, 0)
        metres: FloatArray = map_coordinates(self.metres, cells, order=1, cval=-1.0)
        return metres


def field_of(boxes: Boxes, around: FloatArray, border_m: float) -> Field:
    """Return distances to boxes in all the region that the robot might drive in.

    Points `around`, shape (m, 2), lie inside, at least a border away from the edge.
    """
    points = np.concatenate((boxes.corners().reshape(-1, 2), around))
    origin = points.min(axis=0) - border_m
    shape = np.ceil((points.max(axis=0) + border_m - origin) / _DISTANCE_CELL_M).astype(int) + 1
    grid = np.moveaxis(np.indices(tuple(shape)), 0, -1) * _DISTANCE_CELL_M + origin
    return Field(origin, distance(grid, boxes))


def _border(rect: Rect) -> FloatArray:
    (x0, x1), (y0, y1) = rect.x, rect.y
    across = np.linspace(y0, y1, max(int(np.ceil((y1 - y0) / _SPACING_M)), 1) + 1)
    along = np.linspace(x0, x1, max(int(np.ceil((x1 - x0) / _SPACING_M)), 1) + 1)
    sides = [np.column_stack((np.full(len(across), x), across)) for x in (x0, x1)]
    sides += [np.column_stack((along, np.full(len(along), y))) for y in (y0, y1)]
    return np.concatenate(sides)


def _length(way: curves.Way) -> float:
    return sum(abs(length) + abs(turn) for length, turn in way)


_TURN = STEP_M / RADIUS_M
_MOTIONS: tuple[curves.Motion, ...] = (
    *((STEP_M, turn) for turn in (0.0, _TURN, -_TURN)),
    *((-STEP_M, turn) for turn in (0.0, _TURN, -_TURN)),
    (0.0, np.pi / 8),
    (0.0, -np.pi / 8),
)
_COSTS = np.array([curves.cost_of((motion,)) for motion in _MOTIONS])
_LENGTHS = np.array([_length((motion,)) for motion in _MOTIONS])
_HEADINGS = 32
_CELL_M = 0.3
_EAGER = 40
"""Goals are tried from each of the first states, then from each eighth."""
_PATIENCE = 12_000
_GREED = 1.3
_CONTENT = 0.7
"""A way is taken when nothing promises to be cheaper than this share of its cost."""


class NoWayError(Exception):
    """Nothing leads there."""


@dataclass(frozen=True, slots=True, eq=False)
class _State:
    pose: FloatArray
    cost: float
    before: _State | None
    way: curves.Way
    """From the state before."""
    goal: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class _Room:
    field: Field
    outline: FloatArray
    swept: FloatArray
    """The outline along the motions of the search, in the frame where they start."""
    margin: float

    def cost(self, start: FloatArray, way: curves.Way) -> float:
        """Return the cost of a way; infinite where it is too narrow."""
        poses = curves.poses_on(start, way)
        tight = float(self._tight(placed(self.outline, poses)[None])[0])
        return curves.cost_of(way) + tight * _length(way)

    def costs(self, start: FloatArray) -> FloatArray:
        """Return the costs of the search's motions from a pose, shape (k,)."""
        costs: FloatArray = _COSTS + self._tight(placed(self.swept, start)) * _LENGTHS
        return costs

    def _tight(self, points: FloatArray) -> FloatArray:
        """Return the extra cost of a metre for motions of the outline to points (k, n, m, 2)."""
        room = self.field.at(points).min(axis=-1)
        tight = COMFORT_COST * np.clip((COMFORT_M - room) / COMFORT_M, 0, 1).mean(axis=-1)
        narrow: FloatArray = np.where(room.min(axis=-1) < self.margin, np.inf, tight)
        return narrow


def plan(
    start: FloatArray,
    goals: FloatArray,
    outline: FloatArray,
    boxes: Boxes,
    penalty: FloatArray | None = None,
) -> tuple[curves.Way, int]:
    """Return the cheapest way from a pose (3,) to one of several, `goals` (g, 3), and its index.

    `outline` is that of the vehicle and its load in its own frame, as
    :func:`~corpus_tools.world.planning.ways.outline` gives it. `penalty` is the extra cost of
    each goal in metres, shape (g,). Returns motions from the start, and the index of the
    goal. NoWayError if there is no room at the start or the goals, or nothing leads there.
    """
    field = field_of(boxes, np.vstack((start[:2], goals[:, :2])), BORDER_M)
    around = field.at(placed(outline, np.vstack((start, goals)))).min(axis=-1)
    margin = min(MARGIN_M, around[0] - 0.01)
    if margin < 0:
        raise NoWayError("the robot touches something where it stands")
    open_goals = [(i, goal) for i, goal in enumerate(goals) if around[1 + i] >= margin]
    if not open_goals:
        raise NoWayError("there is no room to stand there")
    extra = np.zeros(len(goals)) if penalty is None else penalty
    # What every goal costs on top must not keep the search from ending.
    extra = extra - min(extra[i] for i, _ in open_goals)
    swept = np.stack([placed(outline, _along(motion)) for motion in _MOTIONS])
    room = _Room(field, outline, swept, margin)
    ahead = _distances(field, np.array([goal[:2] for _, goal in open_goals]), outline, margin)
    if not np.isfinite(ahead(start)):
        raise NoWayError("something blocks every way there")
    way = _search(start, open_goals, extra, room, ahead)
    if way is None or way.goal is None:
        raise NoWayError("there is no way wide enough to get there")
    return _shortened(start, _ways(way), room), way.goal


def _search(
    start: FloatArray,
    goals: list[tuple[int, FloatArray]],
    extra: FloatArray,
    room: _Room,
    ahead: _Heuristic,
) -> _State | None:
    order = count()
    queue = [(0.0, next(order), _State(start, 0.0, None, ()))]
    seen: set[tuple[int, ...]] = set()
    best: _State | None = None
    cheapest = np.inf
    expanded = 0
    while queue and expanded < _PATIENCE:
        _, _, state = heapq.heappop(queue)
        if state.goal is not None:
            return state
        if (key := _key(state.pose)) in seen:
            continue
        seen.add(key)
        expanded += 1
        if expanded <= _EAGER or expanded % 8 == 0:
            for last in _arrivals(state, goals, extra, room, cheapest):
                best, cheapest = last, last.cost
                heapq.heappush(queue, (_CONTENT * cheapest, next(order), last))
        for motion, cost in zip(_MOTIONS, room.costs(state.pose).tolist(), strict=True):
            pose = curves.end_of(state.pose, motion)
            if cost == np.inf or _key(pose) in seen or (left := ahead(pose)) == np.inf:
                continue
            stops = state.way and _gear(state.way[-1]) != _gear(motion)
            total = state.cost + cost + (curves.STOP_COST_M if stops else 0.0)
            following = _State(pose, total, state, (motion,))
            heapq.heappush(queue, (total + _GREED * left, next(order), following))
    return best


def _arrivals(
    state: _State,
    goals: list[tuple[int, FloatArray]],
    extra: FloatArray,
    room: _Room,
    cheapest: float,
) -> Iterator[_State]:
    """Yield goals reached directly, each cheaper than those before; no other would be chosen."""
    for i, goal in goals:
        before = state.cost + extra[i]
        for way in _direct(state.pose, goal):
            # Where there is little room it costs more, never less.
            if before + curves.cost_of(way) >= cheapest:
                continue
            cost = before + room.cost(state.pose, way)
            if cost < cheapest:
                cheapest = cost
                yield _State(goal, cost, state, way, i)


def _direct(start: FloatArray, goal: FloatArray) -> list[curves.Way]:
    bends = [curves.dubins(start, goal, radius) for radius in (RADIUS_M, WIDE_RADIUS_M)]
    return [way for way in (*bends, curves.turn_go_turn(start, goal)) if way is not None]


def _ways(state: _State) -> list[curves.Way]:
    ways: list[curves.Way] = []
    here: _State | None = state
    while here is not None:
        ways.append(here.way)
        here = here.before
    return [way for way in reversed(ways) if way]


def _shortened(start: FloatArray, ways: list[curves.Way], room: _Room) -> curves.Way:
    """Return the way with parts replaced by cheaper curves."""
    poses = [start]
    for way in ways:
        poses.append(curves.poses_on(poses[-1], way)[-1])
    chosen: list[curves.Motion] = []
    i = 0
    while i < len(ways):
        for j in range(len(ways), i + 1, -1):
            part = tuple(motion for way in ways[i:j] for motion in way)
            cost = room.cost(poses[i], part)
            direct = _direct(poses[i], poses[j])
            costs = [room.cost(poses[i], way) for way in direct]
            if costs and min(costs) < cost - 1e-6:
                chosen.extend(direct[int(np.argmin(costs))])
                i = j
                break
        else:
            chosen.extend(ways[i])
            i += 1
    return tuple(chosen)


class _Heuristic:
    """Metres to the nearest goal for something as wide as the vehicle, around obstacles."""

    def __init__(self, metres: FloatArray, origin: FloatArray) -> None:
        self._metres, self._origin = metres, origin

    def __call__(self, pose: FloatArray) -> float:
        cell = np.round((pose[:2] - self._origin) / _CELL_M).astype(int)
        if (cell < 0).any() or (cell >= self._metres.shape).any():
            return np.inf
        return float(self._metres[cell[0], cell[1]])


def _distances(field: Field, goals: FloatArray, outline: FloatArray, margin: float) -> _Heuristic:
    # A point of the vehicle that is as far from its sides as can be: half its width.
    width = float(np.abs(outline[:, 1]).max())
    shape = np.ceil(np.array(field.metres.shape) / 3).astype(int)
    cells = np.indices(tuple(shape)).reshape(2, -1)
    near = map_coordinates(field.metres, cells * 3.0, order=1, cval=-1.0)
    # The grid is coarse: what is free between two cells counts as free.
    free = (near > min(margin + width, near.max()) - _CELL_M).reshape(shape)
    number = np.arange(free.size).reshape(shape)
    rows, columns, lengths = [], [], []
    for dx, dy in ((1, 0), (0, 1), (1, 1), (1, -1)):
        a = np.s_[: shape[0] - dx, max(-dy, 0) : shape[1] - max(dy, 0)]
        b = np.s_[dx:, max(dy, 0) : shape[1] + min(dy, 0)]
        both = free[a] & free[b]
        rows.append(number[a][both])
        columns.append(number[b][both])
        lengths.append(np.full(both.sum(), _CELL_M * np.hypot(dx, dy)))
    graph = coo_array(
        (np.concatenate(lengths), (np.concatenate(rows), np.concatenate(columns))),
        shape=(free.size, free.size),
    ).tocsr()
    ends = np.round((goals - field.origin) / _CELL_M).astype(int)
    seeds = np.unique(number[ends[:, 0], ends[:, 1]])
    metres = dijkstra(graph, directed=False, indices=seeds, min_only=True)
    return _Heuristic(metres.reshape(shape), field.origin)


def _along(motion: curves.Motion) -> FloatArray:
    length, turn = (np.array(value) for value in motion)
    return arc(np.zeros(3), length, turn, np.arange(1, 5) / 4)


def _gear(motion: curves.Motion) -> float:
    return float(np.sign(motion[0]))


def _key(pose: FloatArray) -> tuple[int, ...]:
    heading = int(np.round(wrap(pose[2]) / (2 * np.pi) * _HEADINGS)) % _HEADINGS
    return (*(int(c) for c in np.round(pose[:2] / _CELL_M)), heading)
