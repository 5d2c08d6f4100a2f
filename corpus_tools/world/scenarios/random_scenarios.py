"""Random scenarios that can be carried out: drafts, the room in them, and their scripts."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

import msgspec
import numpy as np
import numpy.typing as npt
from scipy.ndimage import distance_transform_edt, label

from corpus_tools.world.scenarios.boxes import (
    Box,
    overlapping,
    place_box,
    put_box,
    solid,
    start_boxes,
    thing_box,
)
from corpus_tools.world.scenarios.scenario import (
    ROBOT,
    Bounds,
    Layout,
    Point,
    Region,
    Robot,
    Scenario,
    Thing,
)
from corpus_tools.world.scenarios.scenario_validation import scenario_problems
from corpus_tools.world.state import robot_script
from corpus_tools.world.state.thing_kinds import KINDS
from g3.errors import FormatError
from g3.geometry.plane import rotate
from g3.groundings import Colour, FloatArray
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

ATTEMPTS = 200
"""Number of attempts at a scenario before the layout counts as full."""
BYSTANDERS = (3, 10)
"""Number of additional things around, from and up to."""
GAPS_M = (0.6, 2.5)
"""Smallest distances between things."""
PAINTED = 0.4
"""The share of crates and boxes that have a colour."""

_KINDS = {
    "tire-pallet": 4,
    "box-pallet": 4,
    "crate": 2,
    "barrel": 2,
    "person": 2,
    "cone": 1,
    "shelf": 1,
    "trailer": 1,
    "truck": 1,
}
"""Relative frequencies of the kinds of things around."""
_PAINTABLE = ("box-pallet", "crate")
_PAINTS: tuple[Colour, ...] = ("red", "blue", "green", "yellow", "white", "black")


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
    labels = regions[at[:, 0], at[:, 1]]
    return bool(labels[0] > 0 and (labels == labels[0]).all())


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


def generate(seed: int, number: int, layouts: Mapping[str, Layout]) -> Scenario:
    """Generate the scenario with a number among those of a seed, in one of the layouts.

    It depends on the seed, the number and the layouts alone. The tasks take turns, so that
    scenarios with numbers in a row cover all of them. Nothing is in anything else. The robot has
    lanes to all that it enters or puts down. There is a way with room to turn between all places
    where it must be. FormatError if the layouts have no room.
    """
    rng = np.random.default_rng([seed, number])
    task = TASKS[number % len(TASKS)]
    for _ in range(ATTEMPTS):
        layout = layouts[sorted(layouts)[int(rng.integers(len(layouts)))]]
        draft = Draft(layout, rng)
        try:
            title, script = add_task(draft, task)
        except NoRoomError:
            continue
        _add_bystanders(draft)
        _paint(draft, np.random.default_rng([seed, number, 1]))
        scenario = Scenario(
            id=f"generated-{seed}-{number:04}",
            title=title,
            layout=layout,
            objects=draft.objects,
            places=draft.places,
            robot=draft.robot,
            script=script,
        )
        if not scenario_problems(scenario):
            return scenario
    raise FormatError(
        f"there is no room for scenario {number} ({task.name})",
        where=", ".join(sorted(layouts)),
        fix="use larger or emptier layouts",
    )


def _paint(draft: Draft, rng: np.random.Generator) -> None:
    """Give some loads a colour; where things stand doesn't depend on it."""
    for name, thing in draft.objects.items():
        if thing.kind in _PAINTABLE and rng.random() < PAINTED:
            colour = _PAINTS[int(rng.integers(len(_PAINTS)))]
            draft.objects[name] = msgspec.structs.replace(thing, colours=(colour,))


def _add_bystanders(draft: Draft) -> None:
    rng = draft.rng
    weights = np.array(list(_KINDS.values()), dtype=float)
    low, high = BYSTANDERS
    for _ in range(int(rng.integers(low, high + 1))):
        kind = list(_KINDS)[int(rng.choice(len(_KINDS), p=weights / weights.sum()))]
        gap = float(rng.uniform(*GAPS_M))
        try:
            name = draft.thing(kind, gap, margin_m=1.0)
        except NoRoomError:
            continue
        if not draft.passable():
            del draft.objects[name]


Steps: TypeAlias = tuple[robot_script.ScriptStep, ...]
Spot: TypeAlias = tuple[Point, float]
"""A position and a heading in degrees."""

LOADS = {"tire-pallet": "a pallet of tires", "box-pallet": "a pallet of boxes", "crate": "a crate"}
CARRIERS = {"truck": "a truck", "trailer": "a trailer"}
LANDMARKS = {"person": "a person", "barrel": "a barrel", "shelf": "a shelf", "truck": "a truck"}

SLOT_M = 1.5
"""From the middle of one load on a deck to that of the next."""
DECK_EDGE_M = 0.02
"""Loads on decks stand this far from the edge over which they come."""
DECK_PLACE_M = (1.4, 1.4)
ROW_M = (2.4, 3.2)
"""From one load of a row to the next."""


@dataclass(frozen=True, slots=True)
class Task:
    """A kind of scenario."""

    name: str
    """Name in the generator's listing."""
    source: str
    """Source of the load: the forks, the ground, a truck or a trailer; or none."""
    goal: str
    """Goal of the task."""


TASKS = (
    Task("go to an area", "none", "drive"),
    Task("pick up", "ground", "lift"),
    Task("put on a trailer", "ground", "trailer"),
    Task("go to an area loaded", "forks", "drive"),
    Task("put down", "forks", "area"),
    Task("put on a truck", "ground", "truck"),
    Task("move a pallet to another one", "ground", "beside"),
    Task("move from truck to truck", "truck", "truck"),
    Task("put into storage", "ground", "storage"),
    Task("drive past something", "none", "past"),
    Task("put on a loaded truck", "ground", "loaded truck"),
    Task("unload a trailer", "trailer", "area"),
    Task("drive up to something", "none", "approach"),
    Task("pick up from a truck", "truck", "lift"),
    Task("put down on a trailer", "forks", "trailer"),
    Task("drive past something loaded", "forks", "past"),
)


def add_task(draft: Draft, task: Task) -> tuple[str, tuple[robot_script.ScriptStep, ...]]:
    """Put a task's things and the robot into a draft, and return its title and its script.

    NoRoomError if there is no room for something.
    """
    kind = _one_of(draft, LOADS)
    source = ""
    picks: Steps = ()
    if task.source not in ("none", "forks"):
        load, source = _SOURCES[task.source](draft, kind)
        picks = (robot_script.ScriptStep(robot_script.PICK_UP.name, load),)
    goal, steps = _GOALS[task.goal](draft, kind)
    draft.place_robot(kind if task.source == "forks" else None)
    title = f"The forklift {goal}."
    if task.source == "forks":
        title = f"The forklift, which carries {LOADS[kind]}, {goal}."
    load = "it" if task.source == "forks" else LOADS[kind]
    return title.format(load=f"{load} {source}".strip()), (*picks, *steps)


def _one_of(draft: Draft, names: dict[str, str]) -> str:
    return list(names)[int(draft.rng.integers(len(names)))]


def _load_on_ground(draft: Draft, kind: str) -> tuple[str, str]:
    """Add a load that the robot can enter along its heading, perhaps in a row of others."""
    for at, yaw in draft.somewhere(2.0):
        box = solid(KINDS[kind], at, yaw, 0.0)
        try:
            draft.lane(box, float(box.pose[2]), 0.8)
        except NoRoomError:
            continue
        name = draft.id_for(kind)
        draft.objects[name] = Thing(kind, at, yaw)
        if draft.rng.random() < 0.5:
            _add_row(draft, box, yaw)
        return name, ""
    raise NoRoomError(kind)


def _add_row(draft: Draft, box: Box, yaw: float) -> None:
    """Add loads beside a load, to the left and the right, as far as there is room."""
    spacing = float(draft.rng.uniform(*ROW_M))
    for i in draft.rng.permutation([-2, -1, 1, 2])[: int(draft.rng.integers(1, 5))]:
        offset = rotate(np.array([0.0, spacing * int(i)]), box.pose[2])
        draft.try_thing(Thing(_one_of(draft, LOADS), rounded(box.middle + offset), yaw), 0.5)


def _load_on_deck(draft: Draft, carrier_kind: str, kind: str) -> tuple[str, str]:
    carrier, side = _carrier(draft, carrier_kind)
    at, yaw = _slot(draft, carrier, side, kind)
    name = draft.id_for(kind)
    draft.objects[name] = Thing(kind, at, yaw, carrier)
    return name, f"from {CARRIERS[carrier_kind]}"


def _carrier(draft: Draft, kind: str) -> tuple[str, int]:
    """Choose a truck or a trailer, of the layout or new, and a side that can be reached."""
    used = {*(t.deck for t in draft.objects.values()), *(r.deck for r in draft.places.values())}
    unused = [n for n, t in draft.layout.objects.items() if t.kind == kind and n not in used]
    if unused and draft.rng.random() < 0.5:
        name = unused[int(draft.rng.integers(len(unused)))]
        return name, _free_side(draft, name)
    for at, yaw in draft.somewhere(2.5):
        name = draft.try_thing(Thing(kind, at, yaw), 1.5) or ""
        if name:
            try:
                return name, _free_side(draft, name)
            except NoRoomError:
                del draft.objects[name]
    raise NoRoomError(kind)


def _free_side(draft: Draft, carrier: str) -> int:
    """Return 1 for the left side of a carrier, -1 for the right one."""
    thing = draft.all_objects[carrier]
    low, high = deck_of(thing)
    box = thing_box(thing, draft.all_objects, draft.robot)
    for side in draft.rng.permutation([-1, 1]).tolist():
        out = rotate(
            np.array([(low + high) / 2, side * (box.size[1] / 2 + RUN_UP_M / 2)]), box.pose[2]
        )
        pose = np.array([*(box.pose[:2] + out), box.pose[2]])
        room = Box(pose, (high - low, RUN_UP_M), 0.0, 3.0)
        others = [item for item in draft.boxes().items() if item[0] != carrier]
        if draft.inside(room) and not overlapping(room, others):
            return int(side)
    raise NoRoomError(carrier)


def _slot(draft: Draft, carrier: str, side: int, kind: str) -> Spot:
    """Find a free position for a load on a deck, near the side it comes over, and its heading."""
    thing = draft.all_objects[carrier]
    low, high = deck_of(thing)
    box = thing_box(thing, draft.all_objects, draft.robot)
    depth, width = KINDS[kind].size
    count = int((high - low - width) // SLOT_M) + 1
    first = (low + high - (count - 1) * SLOT_M) / 2
    across = side * (box.size[1] / 2 - depth / 2 - DECK_EDGE_M)
    yaw = thing.yaw_deg - 90.0 * side
    loads = [(n, b) for n, b in draft.boxes().items() if draft.all_objects[n].deck == carrier]
    for i in draft.rng.permutation(count).tolist():
        offset = rotate(np.array([first + i * SLOT_M, across]), box.pose[2])
        at = box.pose[:2] + offset
        x, y = round(float(at[0]), 2) + 0.0, round(float(at[1]), 2) + 0.0
        load = solid(KINDS[kind], (x, y), yaw, box.z_max)
        if overlapping(load.grown(0.05), loads):
            continue
        try:
            draft.lane(load, float(load.pose[2]), but=(carrier, *(n for n, _ in loads)))
        except NoRoomError:
            continue
        return (x, y), (yaw + 180.0) % 360.0 - 180.0
    raise NoRoomError(carrier)


def _drive(draft: Draft, kind: str) -> tuple[str, Steps]:
    name, title = _area(draft, "")
    middle = draft.region_box(name).middle
    pose = np.array([*middle, 0.0])
    draft.keep(Box(pose, (2 * TURNING_M, 2 * TURNING_M), 0.0, 3.0))
    draft.stop(middle)
    return f"drives to {title}", (robot_script.ScriptStep(robot_script.DRIVE_TO.name, name),)


def _put_in(draft: Draft, kind: str, stem: str) -> tuple[str, Steps]:
    """Put down in an area, coming from its open side."""
    name, title = _area(draft, stem)
    region = draft.region_box(name)
    load = put_box(solid(KINDS[kind], (0.0, 0.0), 0.0, 0.0), region)
    for quarter in draft.rng.permutation(4).tolist():
        try:
            draft.lane(load, float(region.pose[2]) + quarter * np.pi / 2, 0.6)
        except NoRoomError:
            continue
        return f"brings {{load}} to {title}", (
            robot_script.ScriptStep(robot_script.PUT_DOWN.name, name),
        )
    raise NoRoomError(name)


def _area(draft: Draft, stem: str) -> tuple[str, str]:
    """Choose an area of the layout or a new one; return its id and its name."""
    areas = [name for name in draft.layout.places if name.startswith(stem)]
    if areas:
        name = areas[int(draft.rng.integers(len(areas)))]
        return name, draft.layout.places[name].name or "a place"
    for at, _ in draft.somewhere(4.0):
        region = Region(at, (4.0, 4.0), name=stem or "receiving")
        middle = Box(np.array([*at, 0.0]), region.size, 0.0, 3.0)
        if draft.fits(middle, 0.0):
            name = draft.new_id(stem or "receiving")
            draft.places[name] = region
            return name, region.name
    raise NoRoomError(stem)


def _put_on(draft: Draft, kind: str, carrier_kind: str, loaded: bool) -> tuple[str, Steps]:
    carrier, side = _carrier(draft, carrier_kind)
    if loaded:
        for _ in range(int(draft.rng.integers(1, 3))):
            other = _one_of(draft, LOADS)
            at, yaw = _deck_spot(draft, carrier, side, other)
            draft.objects[draft.id_for(other)] = Thing(other, at, yaw, carrier)
    at, yaw = _slot(draft, carrier, side, kind)
    name = f"on-{carrier}"
    draft.places[name] = Region(at, DECK_PLACE_M, yaw, carrier)
    title = ("a loaded " if loaded else "a ") + carrier_kind
    return f"puts {{load}} on {title}", (robot_script.ScriptStep(robot_script.PUT_DOWN.name, name),)


def _deck_spot(draft: Draft, carrier: str, side: int, kind: str) -> Spot:
    """Find a slot that needs no lane."""
    free, stops = list(draft.free), list(draft.stops)
    spot = _slot(draft, carrier, side, kind)
    draft.free[:], draft.stops[:] = free, stops
    return spot


def _put_beside(draft: Draft, kind: str) -> tuple[str, Steps]:
    """Put down to the left or the right of another load."""
    other = _one_of(draft, LOADS)
    gap = float(draft.rng.uniform(*ROW_M))
    for at, yaw in draft.somewhere(3.0):
        neighbour = solid(KINDS[other], at, yaw, 0.0)
        side = 1 if draft.rng.random() < 0.5 else -1
        offset = rotate(np.array([0.0, side * gap]), neighbour.pose[2])
        spot = rounded(neighbour.middle + offset)
        load = solid(KINDS[kind], spot, yaw, 0.0)
        if not draft.fits(neighbour, 0.8):
            continue
        try:
            draft.lane(load, float(load.pose[2]), 0.4)
            draft.keep(neighbour)
        except NoRoomError:
            continue
        beside = draft.id_for(other)
        draft.objects[beside] = Thing(other, at, yaw)
        name = f"beside-{beside}"
        draft.places[name] = Region(spot, yaw_deg=yaw)
        title = f"moves {{load}} beside {LOADS[other]}"
        return title, (robot_script.ScriptStep(robot_script.PUT_DOWN.name, name),)
    raise NoRoomError(kind)


def _past(draft: Draft, kind: str) -> tuple[str, Steps]:
    """Drive past something that has room all around."""
    name, what = _landmark(draft, LANE_M + 3.0)
    return f"drives past {what}", (robot_script.ScriptStep(robot_script.DRIVE_PAST.name, name),)


def _approach(draft: Draft, kind: str) -> tuple[str, Steps]:
    name, what = _landmark(draft, LANE_M)
    return f"drives up to {what}", (robot_script.ScriptStep(robot_script.APPROACH.name, name),)


def _landmark(draft: Draft, room_m: float) -> tuple[str, str]:
    """Choose a thing with room all around; the robot can get to each side of it."""
    kind = _one_of(draft, LANDMARKS)
    for at, yaw in draft.somewhere(room_m + 1.0):
        box = solid(KINDS[kind], at, yaw, 0.0)
        around = box.grown(room_m)
        if not draft.fits(around, 0.0):
            continue
        draft.free.append(Box(around.pose, around.size, 0.0, 3.0))
        name = draft.id_for(kind)
        draft.objects[name] = Thing(kind, at, yaw)
        draft.stops.extend(box.grown(TURNING_M + 0.4).footprint)
        return name, LANDMARKS[kind]
    raise NoRoomError(kind)


_SOURCES: dict[str, Callable[[Draft, str], tuple[str, str]]] = {
    "ground": _load_on_ground,
    "truck": lambda draft, kind: _load_on_deck(draft, "truck", kind),
    "trailer": lambda draft, kind: _load_on_deck(draft, "trailer", kind),
}

_GOALS: dict[str, Callable[[Draft, str], tuple[str, Steps]]] = {
    "lift": lambda _draft, _kind: ("picks up {load}", ()),
    "drive": _drive,
    "area": lambda draft, kind: _put_in(draft, kind, ""),
    "storage": lambda draft, kind: _put_in(draft, kind, "storage"),
    "trailer": lambda draft, kind: _put_on(draft, kind, "trailer", loaded=False),
    "truck": lambda draft, kind: _put_on(draft, kind, "truck", loaded=False),
    "loaded truck": lambda draft, kind: _put_on(draft, kind, "truck", loaded=True),
    "beside": _put_beside,
    "past": _past,
    "approach": _approach,
}
