"""Room of the robot: obstacles, straight ways in and out, and supports of things."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from corpus_tools.world.physics.behaviours import ActionError, Load, Robot
from corpus_tools.world.planning.ways import Boxes, Rect, outline, room
from corpus_tools.world.state import dimensions as sizes
from corpus_tools.world.state.recording import heading
from corpus_tools.world.state.shapes import Shape
from corpus_tools.world.state.solids import beside_deck, cab_top, deck_of
from corpus_tools.world.state.thing_kinds import kind_of
from g3.actions.courses import direction
from g3.geometry.footprints import centre
from g3.geometry.plane import convex_hull, cross, rotate
from g3.groundings import FloatArray, Place
from g3.short_repr import short_repr

STRAIGHT_MARGIN_M = 0.03
"""Room that the robot keeps where it goes straight in to something."""
READY_MARGIN_M = 0.12
"""Room that it needs where it stops before it goes in, or turns away."""

_TINES_Y = sizes.FORK_Y + sizes.FORK_WIDTH / 2
CHASSIS_OUTLINE = outline((Rect((sizes.CHASSIS[0][0], sizes.MAST[0][1]), sizes.CHASSIS[1]),))
FORKS_OUTLINE = outline(
    (
        Rect((sizes.MAST[0][1], sizes.HEEL_X), sizes.BACKREST[1]),
        Rect((sizes.HEEL_X, sizes.HEEL_X + sizes.FORK_LENGTH), (-_TINES_Y, _TINES_Y)),
    )
)
_CHASSIS_Z = (sizes.MAST[2][0], sizes.MAST[2][1])


def load_rect(load: Load, shape: Shape) -> Rect:
    """Return the rectangle of a load on the forks, in the robot's frame."""
    corners = np.array([[x, y] for x in (0, 1) for y in (0, 1)]) * shape.size[:2] + shape.low[:2]
    xy = load.xy + rotate(corners, np.array(load.yaw))
    (x0, y0), (x1, y1) = xy.min(axis=0).tolist(), xy.max(axis=0).tolist()
    return Rect((x0, x1), (y0, y1))


def robot_outline(robot: Robot, load: Load | None) -> FloatArray:
    """Return the outline of the robot with a load on its forks, or without."""
    parts = [CHASSIS_OUTLINE, FORKS_OUTLINE]
    if load is not None:
        parts.append(outline((load_rect(load, robot.shape(load.id)),)))
    return np.concatenate(parts)


def boxes_of(robot: Robot, *but: str | None) -> Boxes:
    """Return all but the robot, its load and some objects, as boxes with heights above ground."""
    held = robot.load.id if robot.load else None
    rows = []
    for item in robot.start.objects:
        if item.id in (robot.start.agent_id, held, *but):
            continue
        kind, shape = kind_of(item.labels), robot.shape(item.id)
        xyz, orientation = robot.body_pose(item.id)
        yaw, bottom = heading(orientation), xyz[2] - robot.ground_m
        (x0, y0, z0), (x1, y1, z1) = shape.low.tolist(), shape.high.tolist()
        under = 0.0 if kind.deck is not None else z0 + bottom
        solids = [(x0, x1, under, z1 + bottom)]
        if kind.deck is not None:
            solids += [
                (a, b, z1 + bottom, cab_top(z1 + bottom)) for a, b in beside_deck(kind, shape)
            ]
        for a, b, low, high in solids:
            middle = xyz[:2] + rotate(np.array([(a + b) / 2, (y0 + y1) / 2]), yaw)
            rows.append((*middle, float(yaw), (b - a) / 2, (y1 - y0) / 2, low, high))
    table = np.array(rows).reshape(-1, 7)
    return Boxes(table[:, :2], table[:, 2], table[:, 3:5], table[:, 5:])


def behind(pose: FloatArray, metres: float) -> FloatArray:
    """Return the pose straight back from another."""
    return np.array([*(pose[:2] - metres * direction(pose[2])), pose[2]])


def all_behind(pose: FloatArray, metres: FloatArray) -> FloatArray:
    """Return the poses (n, 3) straight back from another, so many metres (n,)."""
    xy = pose[:2] - metres[:, None] * direction(pose[2])
    return np.column_stack((xy, np.full(len(metres), pose[2])))


def fits_straight(
    final: FloatArray, back_m: float, boxes: Boxes, carried: FloatArray, band: tuple[float, float]
) -> bool:
    """Check that the robot can go straight to a pose from some metres behind it.

    `carried` is the outline of the forks and what is on them, `band` between which heights these
    are.
    """
    steps = np.linspace(0, back_m, max(int(np.ceil(back_m / 0.1)), 1) + 1)
    return bool(fits(all_behind(final, steps), boxes, carried, band).all())


def fits(
    poses: FloatArray, boxes: Boxes, carried: FloatArray, band: tuple[float, float]
) -> npt.NDArray[np.bool_]:
    """Return the poses (n, 3) with room for the robot that goes straight in, as a mask (n,).

    The parameters are those of :func:`fits_straight`.
    """
    free = room(poses, CHASSIS_OUTLINE, boxes.between(*_CHASSIS_Z)) >= STRAIGHT_MARGIN_M
    free[free] = room(poses[free], carried, boxes.between(*band)) >= STRAIGHT_MARGIN_M
    return free


FARTHEST_BEHIND_M = 4.0
"""Largest distance behind a pose at which the robot gets ready, in metres."""


def ready_behind(
    final: FloatArray, around: FloatArray, boxes: Boxes, least_m: float
) -> float | None:
    """Return the distance behind a pose at which the robot is clear; None if it nowhere is."""
    backs = np.arange(least_m, FARTHEST_BEHIND_M, 0.1)
    free = room(all_behind(final, backs), around, boxes) >= READY_MARGIN_M
    return float(backs[np.argmax(free)]) if free.any() else None


def forks_band(height_m: float) -> tuple[float, float]:
    """Return the heights of the forks and their backrest; the first is their upper side's."""
    return height_m - sizes.FORK_THICKNESS + 0.01, height_m + sizes.BACKREST[2][1]


NUDGE_M = 0.1
"""Distance from the middle of a place, in metres, within which a load counts as in the middle."""
FIRM_M = 0.3
"""Least distance of the middle of a load from the edge of a deck, in metres."""
IN_THE_AIR_M = 0.4
"""Height of a place above its support, in metres, from which it is in the air."""
REACH_M = 3.0
"""Largest distance along each axis at which a spot is looked for, in metres."""
_GRID_M = 0.1
_TOUCH_M = 0.03


def axis_of(place: Place) -> float:
    """Return the heading of a place's longest edge."""
    corners = convex_hull(place.prism.xy)
    edges = np.roll(corners, -1, axis=0) - corners
    x, y = edges[np.argmax(np.hypot(*edges.T))]
    return float(np.arctan2(y, x))


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Support:
    """Support of a load that is put down in a place."""

    height: float
    """Height above the ground, in metres."""
    axis: float
    """Heading that the load is to be parallel to."""
    carrier: str | None = None
    """The object, None for the ground."""
    deck: FloatArray | None = None
    """Corners (4, 2) of the part of the object that can be loaded, counterclockwise; None on the
    ground."""

    def holds(self, middle: FloatArray) -> bool:
        """Check that a thing with its middle (2,) there can't fall off."""
        if self.deck is None:
            return True
        edges = np.roll(self.deck, -1, axis=0) - self.deck
        inwards = cross(edges, middle - self.deck) / np.hypot(*edges.T)
        return bool((inwards >= FIRM_M).all())


def support_at(robot: Robot, place: Place) -> Support:
    """Return the support of a load in a place's middle; ActionError if that is in the air."""
    low = place.prism.z_min - robot.ground_m
    support = Support(0.0, axis_of(place))
    for item in robot.start.objects:
        kind = kind_of(item.labels)
        if kind.deck is None:
            continue
        shape = robot.shape(item.id)
        xyz, orientation = robot.body_pose(item.id)
        yaw = float(heading(orientation))
        begin, end = deck_of(kind, shape)
        right, left = float(shape.low[1]), float(shape.high[1])
        corners = np.array([[begin, right], [end, right], [end, left], [begin, left]])
        deck = xyz[:2] + rotate(corners, np.full(4, yaw))
        height = float(xyz[2] + shape.high[2] - robot.ground_m)
        x, y = rotate(centre(place.prism) - xyz[:2], np.array(-yaw))
        # Over the cab, too: what is wanted up there goes onto the deck.
        over = shape.low[0] <= x <= shape.high[0] and right <= y <= left
        if over and abs(height - low) < abs(support.height - low):
            support = Support(height, yaw, item.id, deck)
    if low - support.height > IN_THE_AIR_M:
        raise ActionError(
            f"nothing that can be loaded is under {place.name or 'the place'}, {low:.1f} m up"
        )
    return support


def carrier_under(robot: Robot, thing: str) -> str | None:
    """Return the object that an object stands on, None if that is the ground."""
    shape, (xyz, orientation) = robot.shape(thing), robot.body_pose(thing)
    middle = xyz[:2] + rotate(shape.middle[:2], heading(orientation))
    for item in robot.start.objects:
        if item.id in (thing, robot.start.agent_id):
            continue
        other, (at, turned) = robot.shape(item.id), robot.body_pose(item.id)
        local = rotate(middle - at[:2], -heading(turned))
        over = (other.low[:2] <= local).all() and (local <= other.high[:2]).all()
        if over and abs(at[2] + other.high[2] - xyz[2] - shape.low[2]) < _TOUCH_M:
            return item.id
    return None


def spots(place: Place, footprint: FloatArray) -> Iterator[FloatArray]:
    """Yield offsets (2,) from a place's middle with a footprint in the place, nearest first.

    The middle comes first whether it is or not, then what is a nudge away. `footprint` has the
    corners relative to what stands in the middle, shape (k, 2).
    """
    corners = convex_hull(place.prism.xy) - centre(place.prism)
    edges = np.roll(corners, -1, axis=0) - corners
    reach = round(REACH_M / _GRID_M)
    steps = np.arange(-reach, reach + 1) * _GRID_M
    grid = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
    axis = axis_of(place)
    grid = rotate(grid, np.full(len(grid), axis))
    far = np.hypot(*grid.T)
    at = grid[:, None, None] + footprint[None, :, None] - corners
    inside = (cross(edges, at) >= -0.02).all(axis=(1, 2))
    chosen = np.flatnonzero(inside | (far <= NUDGE_M + 1e-9))
    for i in chosen[np.argsort(far[chosen], kind="stable")]:
        yield grid[i]
