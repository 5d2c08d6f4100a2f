"""The room that things take up in the frame of a layout."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from corpus_tools.world.scenarios.scenario import ROBOT, Point, Region, Robot, Thing
from corpus_tools.world.state.thing_kinds import FORKLIFT, KINDS, Kind
from g3.geometry.plane import intersection_area, rotate
from g3.geometry.relations import in_frame
from g3.groundings import FloatArray
from g3.short_repr import short_repr

FORK_HEEL_M = 0.56
"""From the robot's position straight ahead to where loads touch the heel of the forks."""
FORKS_M = (1.0, 0.6)
"""Length of the forks, and width over both."""
FORKS_TOP_M = 0.07
"""Height of the forks when they are down."""
CARRIED_M = 0.15
"""Height of the bottom of a load that is carried at the start above the ground, in metres."""
PLACE_HEIGHT_M = 1.0
"""Height of places above the ground or the deck that they are on, in metres."""
TOUCHING_M2 = 1e-4
"""Footprints that share less than this only touch."""


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Box:
    """An upright box."""

    pose: FloatArray
    """Position and heading (radians) of the thing that fills it, shape (3,)."""
    size: tuple[float, float]
    """Along and across the heading, in metres."""
    z_min: float
    z_max: float
    """Heights of bottom and top."""
    ahead_m: float = 0.0
    """Distance of the middle ahead of the pose, in metres."""

    @property
    def middle(self) -> FloatArray:
        """Middle of the footprint, shape (2,)."""
        ahead: FloatArray = self.pose[:2] + rotate(np.array([self.ahead_m, 0.0]), self.pose[2])
        return ahead

    @property
    def footprint(self) -> FloatArray:
        """Corners, counter-clockwise, shape (4, 2)."""
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * np.array(self.size) / 2
        turned: FloatArray = self.middle + rotate(corners, np.full(4, self.pose[2]))
        return turned

    def grown(self, margin_m: float) -> Box:
        """Return the box with a margin around its footprint."""
        return replace(self, size=(self.size[0] + 2 * margin_m, self.size[1] + 2 * margin_m))

    def offset(self, point: FloatArray) -> FloatArray:
        """Return points (..., 2) seen from the pose, along and across its heading."""
        return in_frame(point, self.pose)


def robot_box(robot: Robot) -> Box:
    """Return the robot at the start."""
    return solid(FORKLIFT, robot.at, robot.yaw_deg, 0.0)


def forks_box(robot: Robot) -> Box:
    """Return the robot's forks at the start, which are no part of its footprint."""
    pose = _pose(robot.at, robot.yaw_deg)
    return Box(pose, FORKS_M, 0.0, FORKS_TOP_M, FORK_HEEL_M + FORKS_M[0] / 2)


def thing_box(thing: Thing, objects: Mapping[str, Thing], robot: Robot) -> Box:
    """Return an object at the start; one without a position is on the forks.

    The one on whose deck it is is among `objects`.
    """
    kind = KINDS[thing.kind]
    if thing.at is not None:
        return solid(kind, thing.at, thing.yaw_deg, deck_height(thing.deck, objects))
    turn = np.deg2rad(thing.yaw_deg)
    depth = abs(np.cos(turn)) * kind.size[0] + abs(np.sin(turn)) * kind.size[1]
    reach = rotate(np.array([FORK_HEEL_M + depth / 2, 0.0]), np.deg2rad(robot.yaw_deg))
    at = (float(robot.at[0] + reach[0]), float(robot.at[1] + reach[1]))
    return solid(kind, at, robot.yaw_deg + thing.yaw_deg, CARRIED_M)


def place_box(region: Region, objects: Mapping[str, Thing]) -> Box:
    """Return the box of a place."""
    low = deck_height(region.deck, objects)
    return Box(_pose(region.at, region.yaw_deg), region.size, low, low + PLACE_HEIGHT_M)


def put_box(load: Box, place: Box) -> Box:
    """Return a load that stands in the middle of a place, parallel to it."""
    height = load.z_max - load.z_min
    return replace(load, pose=place.pose, z_min=place.z_min, z_max=place.z_min + height)


def solid(kind: Kind, at: Point, yaw_deg: float, low: float) -> Box:
    """Return the box of a thing of a kind that stands at a height."""
    bottom, top = kind.heights
    return Box(_pose(at, yaw_deg), kind.size, low + bottom, low + top, kind.ahead_m)


def deck_height(carrier: str | None, objects: Mapping[str, Thing]) -> float:
    """Return the height of an object's deck; of the ground if there is none."""
    return 0.0 if carrier is None else KINDS[objects[carrier].kind].heights[1]


def overlapping(box: Box, others: Iterable[tuple[str, Box]]) -> list[str]:
    """Return the names of the boxes that share room with a box."""
    level = [
        (name, other)
        for name, other in others
        if other.z_min < box.z_max - 1e-6 and box.z_min < other.z_max - 1e-6
    ]
    if not level:
        return []
    footprints = np.array([other.footprint for _, other in level])
    shared = intersection_area(footprints, np.broadcast_to(box.footprint, footprints.shape).copy())
    return [name for (name, _), area in zip(level, shared, strict=True) if area > TOUCHING_M2]


def start_boxes(objects: Mapping[str, Thing], robot: Robot) -> dict[str, Box]:
    """Return the boxes of all at the start, the robot last.

    A thing with a deck reaches down to the ground: nothing stands below it.
    """
    boxes = {name: thing_box(thing, objects, robot) for name, thing in objects.items()}
    for name, thing in objects.items():
        if KINDS[thing.kind].deck is not None:
            boxes[name] = replace(boxes[name], z_min=0.0)
    return {**boxes, ROBOT: robot_box(robot)}


def _pose(at: Point, yaw_deg: float) -> FloatArray:
    return np.array([at[0], at[1], np.deg2rad(yaw_deg)])
