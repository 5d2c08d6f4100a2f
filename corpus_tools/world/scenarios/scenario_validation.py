"""Validation of scenarios and their scripts, as far as that is possible without driving."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from corpus_tools.world.scenarios.boxes import (
    Box,
    forks_box,
    overlapping,
    place_box,
    put_box,
    start_boxes,
)
from corpus_tools.world.scenarios.documents import Field, Problem
from corpus_tools.world.scenarios.scenario import (
    ROBOT,
    Bounds,
    Layout,
    Region,
    Robot,
    Scenario,
    Thing,
    may_be_lifted,
)
from corpus_tools.world.scenarios.scenario_files import KNOWN
from corpus_tools.world.state.robot_script import ACTIONS, DRIVE_TO, TURN, Script, ScriptStep
from corpus_tools.world.state.thing_kinds import KINDS
from g3.errors import unknown_name
from g3.geometry.plane import point_gap
from g3.groundings import FloatArray

_ID = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")
_EDGE_M = 1e-6


def scenario_problems(scenario: Scenario) -> list[Problem]:
    """Return the problems of a scenario whose layout is right."""
    layout = scenario.layout
    objects, places = scenario.all_objects, scenario.all_places
    robot = scenario.robot
    taken = {**layout.objects, **layout.places}
    problems = [
        *_id_problems(scenario.objects, scenario.places, taken),
        *_object_problems(scenario.objects, objects, robot),
        *_place_problems(scenario.places, objects),
    ]
    if robot.carries is not None:
        problems += _load_problems(robot.carries, objects)
    if problems:
        return problems
    boxes = start_boxes(objects, robot)
    regions = {name: place_box(region, objects) for name, region in places.items()}
    new = {**scenario.objects, ROBOT: None}
    problems += _room_problems(new, boxes, robot.carries)
    problems += _forks_problems(robot, boxes)
    problems += _edge_problems({name: boxes[name] for name in new}, scenario.places, layout.bounds)
    problems += _deck_problems(scenario.objects, scenario.places, objects, boxes, regions)
    return problems or script_problems(scenario.script, objects, robot, boxes, regions)


def layout_problems(layout: Layout) -> list[Problem]:
    """Return the problems of a layout."""
    for axis in ("x", "y"):
        low, high = getattr(layout.bounds, axis)
        if low >= high:
            return [Problem(("bounds", axis), f"{low:g} is not before {high:g}", "correct it")]
    objects = layout.objects
    problems = [
        *_id_problems(objects, layout.places, {}),
        *_object_problems(objects, objects, None),
        *_place_problems(layout.places, objects),
    ]
    if problems:
        return problems
    boxes = start_boxes(objects, Robot((0.0, 0.0)))
    del boxes[ROBOT]
    regions = {name: place_box(region, objects) for name, region in layout.places.items()}
    return [
        *_room_problems(objects, boxes, None),
        *_edge_problems(boxes, layout.places, layout.bounds),
        *_deck_problems(objects, layout.places, objects, boxes, regions),
    ]


def _id_problems(
    objects: Mapping[str, Thing], places: Mapping[str, Region], layout: Mapping[str, object]
) -> Iterator[Problem]:
    for section, names in (("objects", objects), ("places", places)):
        for name in names:
            field = (section, name)
            if not _ID.fullmatch(name):
                yield Problem(
                    field, f"{name!r} can't be an id", "use small letters, digits and hyphens"
                )
            elif name == ROBOT:
                yield Problem(field, f"the id {name!r} is taken by the robot", "use another one")
            elif name in layout:
                yield Problem(field, f"the layout has a {name!r} already", "use another id")
            elif section == "places" and name in objects:
                yield Problem(field, f"an object has the id {name!r}", "use another id")


def _object_problems(
    some: Mapping[str, Thing], objects: Mapping[str, Thing], robot: Robot | None
) -> Iterator[Problem]:
    for name, thing in some.items():
        field = ("objects", name)
        carried = robot is not None and robot.carries == name
        if thing.kind not in KNOWN:
            yield Problem((*field, "kind"), *unknown_name("kind", thing.kind, KNOWN))
        if carried and (thing.at is not None or thing.deck is not None):
            yield Problem(
                (*field, "deck" if thing.at is None else "at"),
                "the robot carries it, so it can't stand somewhere else",
                "leave out at and deck",
            )
        elif not carried and thing.at is None:
            yield Problem(field, "it has no position, and the robot doesn't carry it", "add at")
        if thing.kind in KINDS and thing.liftable and not may_be_lifted(thing):
            loads = ", ".join(name for name, kind in KINDS.items() if kind.carriable)
            yield Problem(
                (*field, "liftable"), f"the forks can't lift a {thing.kind}", f"they lift: {loads}"
            )
        if thing.deck is not None:
            yield from _carrier_problems(thing.deck, objects, (*field, "deck"))


def _place_problems(
    places: Mapping[str, Region], objects: Mapping[str, Thing]
) -> Iterator[Problem]:
    for name, region in places.items():
        if region.deck is not None:
            yield from _carrier_problems(region.deck, objects, ("places", name, "deck"))


def _carrier_problems(
    carrier: str, objects: Mapping[str, Thing], field: Field
) -> Iterator[Problem]:
    below = objects.get(carrier)
    if below is None:
        decks = [name for name, thing in objects.items() if _has_deck(thing)]
        yield Problem(field, *unknown_name("object", carrier, decks))
    elif not _has_deck(below):
        yield Problem(field, f"{carrier!r} has no deck", "name a truck or a trailer")


def _load_problems(load: str, objects: Mapping[str, Thing]) -> Iterator[Problem]:
    field = ("robot", "carries")
    if load not in objects:
        yield Problem(field, *unknown_name("object", load, objects))
    elif objects[load].kind in KINDS and not may_be_lifted(objects[load]):
        yield Problem(field, f"the forks can't lift {load!r}", "name a load")


def _has_deck(thing: Thing) -> bool:
    return thing.kind in KINDS and KINDS[thing.kind].deck is not None


def _room_problems(
    new: Mapping[str, object], boxes: Mapping[str, Box], carried: str | None
) -> Iterator[Problem]:
    """Yield problems of things that overlap; each pair once, at the later one in the file."""
    order = {name: i for i, name in enumerate(boxes)}
    for name in new:
        earlier = [
            (other, box)
            for other, box in boxes.items()
            if other != name
            and (other not in new or order[other] < order[name])
            and {name, other} != {carried, ROBOT}
        ]
        for other in overlapping(boxes[name], earlier):
            yield Problem(_at(name), f"{name} and {other} overlap", "move one away")


def _forks_problems(robot: Robot, boxes: Mapping[str, Box]) -> Iterator[Problem]:
    others = [item for item in boxes.items() if item[0] not in (ROBOT, robot.carries)]
    for other in overlapping(forks_box(robot), others):
        yield Problem(_at(ROBOT), f"the forks and {other} overlap", "move one away")


def _edge_problems(
    boxes: Mapping[str, Box], places: Mapping[str, Region], bounds: Bounds
) -> Iterator[Problem]:
    low = np.array([bounds.x[0], bounds.y[0]]) - _EDGE_M
    high = np.array([bounds.x[1], bounds.y[1]]) + _EDGE_M
    room = f"x from {bounds.x[0]:g} to {bounds.x[1]:g}, y from {bounds.y[0]:g} to {bounds.y[1]:g}"

    def outside(corners: FloatArray) -> bool:
        return bool((corners < low).any() or (corners > high).any())

    for name, box in boxes.items():
        if outside(box.footprint):
            yield Problem(_at(name), f"{name} is outside the layout", f"its bounds are {room}")
    for name, region in places.items():
        if outside(place_box(region, {}).footprint if region.deck is None else np.array(region.at)):
            yield Problem(
                ("places", name, "at"), f"{name} is outside the layout", f"its bounds are {room}"
            )


def _deck_problems(
    some: Mapping[str, Thing],
    places: Mapping[str, Region],
    objects: Mapping[str, Thing],
    boxes: Mapping[str, Box],
    regions: Mapping[str, Box],
) -> Iterator[Problem]:
    def on_deck(points: FloatArray, carrier: str) -> bool:
        kind = KINDS[objects[carrier].kind]
        assert kind.deck is not None  # noqa: S101 - what has none is no carrier
        away = boxes[carrier].offset(points)
        low = np.array([kind.deck[0], -kind.size[1] / 2]) - _EDGE_M
        high = np.array([kind.deck[1], kind.size[1] / 2]) + _EDGE_M
        return bool((away >= low).all() and (away <= high).all())

    for name, thing in some.items():
        if thing.deck is not None and not on_deck(boxes[name].footprint, thing.deck):
            yield Problem(_at(name), f"{name} is not wholly on the deck of {thing.deck}", "move it")
    for name, region in places.items():
        if region.deck is not None and not on_deck(regions[name].middle[None], region.deck):
            yield Problem(
                ("places", name, "at"),
                f"the middle of {name} is not on the deck of {region.deck}",
                "move it",
            )


def _at(name: str) -> Field:
    return ("robot", "at") if name == ROBOT else ("objects", name, "at")


STANDING_ROOM_M = 0.6
"""The robot's middle keeps this far from anything where it stops in a place."""


def script_problems(
    script: Script,
    objects: Mapping[str, Thing],
    robot: Robot,
    boxes: Mapping[str, Box],
    regions: Mapping[str, Box],
) -> list[Problem]:
    """Return the problems of a script, followed up to the first step that is impossible.

    `boxes` are everything at the start, `regions` the places.
    """
    state = _State(objects, dict(boxes), regions, robot.carries)
    for i, step in enumerate(script):
        for what, fix in state.follow(step):
            return [Problem(("script", i, step.action), what, fix)]
    return []


@dataclass(slots=True)
class _State:
    """State of everything between two steps, as far as the steps determine it."""

    objects: Mapping[str, Thing]
    boxes: dict[str, Box]
    regions: Mapping[str, Box]
    held: str | None
    moved: set[str] = field(default_factory=set)

    def follow(self, step: ScriptStep) -> Iterator[tuple[str, str]]:
        """Follow a step, and yield its problems."""
        action = ACTIONS.get(step.action)
        if action is None:
            yield unknown_name("action", step.action, ACTIONS)
            return
        wrong = {
            "object": self.wrong_object,
            "place": self.wrong_place,
            "number": self.wrong_number,
        }[action.argument](step)
        if wrong is not None:
            yield wrong
        elif action.kind.takes:
            yield from self.pick_up(str(step.argument))
        elif action.kind.leaves:
            yield from self.put_down(str(step.argument))
        elif action is DRIVE_TO:
            yield from self.drive_to(str(step.argument))

    def wrong_object(self, step: ScriptStep) -> tuple[str, str] | None:
        if step.argument not in self.objects:
            return unknown_name("object", step.argument, self.objects)
        if step.argument == self.held and step.kind is not None and step.kind.aims:
            return f"{step.argument} is on the forks", "name another object"
        return None

    def wrong_place(self, step: ScriptStep) -> tuple[str, str] | None:
        if step.argument not in self.regions:
            return unknown_name("place", step.argument, self.regions)
        return None

    def wrong_number(self, step: ScriptStep) -> tuple[str, str] | None:
        if isinstance(step.argument, str):
            return f"{step.argument!r} is no number", "give one"
        if step.action != TURN.name and step.argument <= 0:
            return f"{step.argument:g} is not more than 0", "correct it"
        return None

    def pick_up(self, load: str) -> Iterator[tuple[str, str]]:
        if not may_be_lifted(self.objects[load]):
            yield f"the forks can't lift {load}", "name a load"
        elif self.held is not None:
            yield f"{self.held} is on the forks already", "put it down before"
        else:
            self.held = load

    def put_down(self, place: str) -> Iterator[tuple[str, str]]:
        if self.held is None:
            yield "nothing is on the forks", "pick something up before"
            return
        box = put_box(self.boxes[self.held], self.regions[place])
        others = [(n, b) for n, b in self.boxes.items() if n not in (ROBOT, self.held)]
        for other in overlapping(box, others):
            yield f"{other} is in {place}, where {self.held} is to stand", "make room"
            return
        self.boxes[self.held] = box
        self.held = None

    def drive_to(self, place: str) -> Iterator[tuple[str, str]]:
        region = self.regions[place]
        if region.z_min > 0:
            yield f"{place} is on a deck, where the robot can't drive", "name another place"
            return
        for name, box in self.boxes.items():
            if name in (ROBOT, self.held):
                continue
            gap = point_gap(region.middle[None, None], box.footprint[None])[0, 0]
            if gap < STANDING_ROOM_M:
                yield f"{name} is in the middle of {place}", "make room"
                return
