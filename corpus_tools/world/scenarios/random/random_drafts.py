"""Scenarios in the making, and where a robot can drive and turn in them."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from scipy.ndimage import distance_transform_edt, label

from corpus_tools.world.scenarios.boxes import (
    Box,
    overlapping,
    place_box,
    start_boxes,
    thing_box,
)
from corpus_tools.world.scenarios.scenario import ROBOT, Bounds, Layout, Point, Region, Robot, Thing
from corpus_tools.world.state.thing_kinds import KINDS
from g3.geometry.plane import rotate
from g3.groundings import FloatArray
from g3.short_repr import short_repr

TRIES = 40
"""Number of positions that are tried for one thing."""
EDGE_M = 0.3
"""Things keep this far from the bounds."""
BULKY_M = 2.0
"""Length in metres above which a thing stands in no area."""
LANE_M = 2.4
"""Width of the lane through which the robot enters a load."""
RUN_UP_M = 4.6
"""From the middle of a load to where the robot turns towards it."""

NOWHERE = Robot((1e6, 1e6))
"""Pose of the robot until it is placed."""

_GRID_M = 0.05
_IDS = {"tire-pallet": "tires", "box-pallet": "boxes"}


class NoRoomError(Exception):
    """Something can't be put anywhere."""


@short_repr
@dataclass(slots=True)
class Draft:
    """A scenario that things are added to."""

    layout: Layout
    rng: np.random.Generator
    objects: dict[str, Thing] = field(default_factory=dict)
    places: dict[str, Region] = field(default_factory=dict)
    """Places added so far, by id."""
    robot: Robot = NOWHERE
    """The robot; far away until it is placed."""
    free: list[Box] = field(default_factory=list)
    """Room that nothing further may be put in."""
    stops: list[FloatArray] = field(default_factory=list)
    """Positions that the robot must be able to reach and turn at."""

    @property
    def all_objects(self) -> dict[str, Thing]:
        """The draft's objects and the layout's."""
        return {**self.objects, **self.layout.objects}

    def boxes(self) -> dict[str, Box]:
        """Return the boxes of all placed things."""
        boxes = start_boxes(self.all_objects, self.robot)
        if self.robot is NOWHERE:
            del boxes[ROBOT]
        return boxes

    def new_id(self, stem: str) -> str:
        """Return the first free id of stem-1, stem-2 ..."""
        taken = {**self.all_objects, **self.places, **self.layout.places}
        return next(n for i in itertools.count(1) if (n := f"{stem}-{i}") not in taken)

    def id_for(self, kind: str) -> str:
        """Return a free id for an object of a kind."""
        return self.new_id(_IDS.get(kind, kind))

    def areas(self) -> list[tuple[str, Box]]:
        """Return the areas on the ground that the map names."""
        places = {**self.places, **self.layout.places}
        return [(n, _tall(self.region_box(n))) for n, r in places.items() if r.name and not r.deck]

    def somewhere(self, margin_m: float) -> Iterator[tuple[Point, float]]:
        """Yield positions within the bounds and headings, mostly along the walls."""
        bounds = self.layout.bounds
        if min(high - low for low, high in (bounds.x, bounds.y)) <= 2 * margin_m:
            return
        for _ in range(TRIES):
            x, y = (
                float(self.rng.uniform(low + margin_m, high - margin_m))
                for low, high in (bounds.x, bounds.y)
            )
            yaw = 90.0 * int(self.rng.integers(-1, 3))
            if self.rng.random() < 0.3:
                yaw += float(self.rng.integers(-25, 26))
            yield rounded((x, y)), yaw

    def fits(self, box: Box, gap_m: float) -> bool:
        """Check that a box has a gap to everything and leaves free the room that must be."""
        return (
            self.inside(box)
            and not overlapping(_tall(box.grown(gap_m)), self.boxes().items())
            and not overlapping(_tall(box), ((str(i), f) for i, f in enumerate(self.free)))
        )

    def inside(self, box: Box) -> bool:
        """Check that a box is inside the bounds."""
        bounds, corners = self.layout.bounds, box.footprint
        low = np.array([bounds.x[0], bounds.y[0]]) + EDGE_M
        high = np.array([bounds.x[1], bounds.y[1]]) - EDGE_M
        return bool((corners >= low).all() and (corners <= high).all())

    def try_thing(self, thing: Thing, gap_m: float) -> str | None:
        """Add an object on the ground if there is room; its id."""
        box = thing_box(thing, self.all_objects, self.robot)
        if not self.fits(box, gap_m):
            return None
        if max(box.size) > BULKY_M and overlapping(_tall(box), self.areas()):
            return None
        name = self.id_for(thing.kind)
        self.objects[name] = thing
        return name

    def thing(self, kind: str, gap_m: float, margin_m: float = 2.0) -> str:
        """Add an object somewhere on the ground; its id."""
        for at, yaw in self.somewhere(margin_m):
            name = self.try_thing(Thing(kind, at, yaw), gap_m)
            if name is not None:
                return name
        raise NoRoomError(kind)

    def keep(self, *boxes: Box, but: tuple[str, ...] = ()) -> None:
        """Keep room free, which it must be but for some objects."""
        others = [item for item in self.boxes().items() if item[0] not in but]
        for box in boxes:
            if not self.inside(box) or overlapping(_tall(box), others):
                raise NoRoomError("room")
        self.free.extend(map(_tall, boxes))

    def stop(self, at: FloatArray) -> None:
        """Note that the robot must be able to get to a position."""
        self.stops.append(at)

    def lane(
        self, box: Box, heading: float, margin_m: float = 0.0, *, but: tuple[str, ...] = ()
    ) -> None:
        """Keep a lane free through which the robot drives straight into a box.

        `heading` is the robot's in the lane, in radians; `margin_m` around the box is kept free
        too. What `but` names may be in the way: it is where only the forks go.
        """
        back = rotate(np.array([-1.0, 0.0]), np.array(heading))
        pose = np.array([*(box.middle + back * RUN_UP_M / 2), heading])
        self.keep(Box(pose, (RUN_UP_M, LANE_M), 0.0, 3.0), box.grown(margin_m), but=but)
        self.stop(box.middle + back * RUN_UP_M)

    def passable(self) -> bool:
        """Check that the robot gets from stop to stop."""
        if not self.stops:
            return True
        solid = [
            box for name, box in self.boxes().items() if name not in (ROBOT, self.robot.carries)
        ]
        return connected(np.array(self.stops), solid, self.layout.bounds)

    def place_robot(self, load: str | None) -> None:
        """Put the robot, maybe with a kind of load, where it can turn and gets to every stop."""
        for at, yaw in self.somewhere(TURNING_M + EDGE_M):
            robot = Robot(at, yaw)
            around = Box(np.array([*at, 0.0]), (2 * TURNING_M, 2 * TURNING_M), 0.0, 3.0)
            if not self.fits(around, 0.0):
                continue
            self.robot = robot
            self.stops.append(np.array(at))
            if self.passable():
                self.free.append(around)
                if load is not None:
                    name = self.id_for(load)
                    self.objects[name] = Thing(load)
                    self.robot = Robot(at, yaw, name)
                return
            self.stops.pop()
        self.robot = NOWHERE
        raise NoRoomError("robot")

    def region_box(self, name: str) -> Box:
        """Return the box of a place of the draft or the layout."""
        region = self.places.get(name) or self.layout.places[name]
        return place_box(region, self.all_objects)


def rounded(at: FloatArray | Point) -> Point:
    """Round a position to 5 cm, as in scenarios written by hand."""
    x, y = (round(round(float(v) / _GRID_M) * _GRID_M, 2) + 0.0 for v in at)
    return x, y


def deck_of(thing: Thing) -> tuple[float, float]:
    """Return the part of an object's top that can be loaded, along its heading."""
    deck = KINDS[thing.kind].deck
    assert deck is not None  # noqa: S101 - the callers name carriers
    return deck


def _tall(box: Box) -> Box:
    """Return a box that reaches down to the ground and above everything."""
    return Box(box.pose, box.size, 0.0, 3.0, box.ahead_m)


CELL_M = 0.2
TURNING_M = 2.0
"""The robot with a load turns on the spot within this distance of its position."""

_EIGHT = np.ones((3, 3), dtype=int)

Mask = npt.NDArray[np.bool_]


def connected(points: FloatArray, boxes: Iterable[Box], bounds: Bounds) -> bool:
    """Check that a robot gets from each point to each other one, with room to turn all the way.

    `points` are positions, shape (n, 2), in metres; `boxes` are in the way, at any height; the
    robot's position stays in `bounds`.
    """
    low, high = (np.array([bounds.x[i], bounds.y[i]]) for i in (0, 1))
    if (points < low).any() or (points > high).any():
        return False
    cells = np.ceil((high - low) / CELL_M).astype(int) + 1
    taken: Mask = np.zeros(cells, dtype=bool)
    for box in boxes:
        _fill(taken, box, low)
    # A cell counts as taken if its middle is, which is up to half a diagonal off.
    room = distance_transform_edt(~taken) * CELL_M if taken.any() else np.full(cells, np.inf)
    regions, _ = label(room >= TURNING_M + CELL_M * np.sqrt(0.5), structure=_EIGHT)
    at = np.rint((points - low) / CELL_M).astype(int)
    found = regions[at[:, 0], at[:, 1]]
    return bool(found[0] > 0 and (found == found[0]).all())


def _fill(taken: Mask, box: Box, low: FloatArray) -> None:
    corners = (box.footprint - low) / CELL_M
    first = np.maximum(np.floor(corners.min(axis=0)).astype(int), 0)
    last = np.minimum(np.ceil(corners.max(axis=0)).astype(int) + 1, taken.shape)
    if (first >= last).any():
        return
    x, y = np.meshgrid(*(np.arange(a, b) for a, b in zip(first, last, strict=True)), indexing="ij")
    away = low + CELL_M * np.stack((x, y), axis=-1) - box.middle
    inside = np.abs(rotate(away, np.full(away.shape[:-1], -box.pose[2]))) <= np.array(box.size) / 2
    taken[first[0] : last[0], first[1] : last[1]] |= inside.all(axis=-1)
