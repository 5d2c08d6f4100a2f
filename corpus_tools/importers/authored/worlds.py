"""The contexts of scenarios, with the logs that their actions leave."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass, replace

import numpy as np

from corpus_tools.importers.authored.files import (
    ROBOT,
    Action,
    Dataset,
    Kind,
    Point,
    Region,
    Scenario,
    Site,
    Thing,
)
from g3.action_log import Outcome
from g3.actions import LIFT_M, REACH_M, carry, drive_to, pick_up, put_down
from g3.errors import FormatError
from g3.groundings import Context, FloatArray, PhysicalObject, Place, Prism, Trajectory

PLACE_HEIGHT_M = 1.0
"""Places reach so far above the ground or the deck that they are on."""


@dataclass(frozen=True, slots=True)
class World:
    """A scenario's context with its log.

    Parameters
    ----------
    scenario
        What was written.
    context
        Agent and objects have their trajectories in the log.
    places
        The context's places by id.
    moved
        The object that the action moves, if any.
    """

    scenario: Scenario
    context: Context
    places: dict[str, Place]
    moved: PhysicalObject | None

    @property
    def objects(self) -> dict[str, PhysicalObject]:
        """The context's objects by id, the robot among them."""
        return {item.id: item for item in self.context.objects}


@dataclass(frozen=True, slots=True)
class _Builder:
    """Puts what a scenario holds into the frame of the site's map."""

    dataset: Dataset
    scenario: Scenario
    site: Site
    start_s: float

    def context(self) -> Context:
        things = [self.thing(name, thing) for name, thing in self.scenario.objects.items()]
        return Context(
            id=self.scenario.id,
            objects=(*things, self.robot()),
            places=tuple(self.places().values()),
            agent_id=ROBOT,
        )

    def places(self) -> dict[str, Place]:
        return {name: self.place(name, region) for name, region in self.scenario.places.items()}

    def robot(self) -> PhysicalObject:
        robot = self.scenario.robot
        kind = self.kind(ROBOT, "dataset.yaml: kinds")
        return self.solid(ROBOT, kind, robot.at, robot.yaw_deg, lift=0.0, middle=False)

    def thing(self, name: str, thing: Thing) -> PhysicalObject:
        where = f"objects.{name}"
        kind = self.kind(thing.kind, f"{where}.kind")
        robot = self.scenario.robot
        if name == robot.carries:
            if thing.at is not None or thing.deck is not None:
                raise FormatError(
                    "the robot carries it, so it can't stand somewhere else",
                    where=where,
                    fix="leave out at and deck",
                )
            turn = np.deg2rad(robot.yaw_deg)
            at = (
                robot.at[0] + REACH_M * float(np.cos(turn)),
                robot.at[1] + REACH_M * float(np.sin(turn)),
            )
            return self.solid(name, kind, at, robot.yaw_deg + thing.yaw_deg, lift=LIFT_M)
        if thing.at is None:
            raise FormatError(
                "it has no position, and the robot doesn't carry it", where=where, fix="add at"
            )
        return self.solid(
            name, kind, thing.at, thing.yaw_deg, lift=self.deck(thing.deck, f"{where}.deck")
        )

    def place(self, name: str, region: Region) -> Place:
        low = self.deck(region.deck, f"places.{name}.deck")
        xy = self.footprint(region.at, region.yaw_deg, region.size, f"places.{name}.size")
        return Place(Prism(xy, low, low + PLACE_HEIGHT_M), region.name)

    def kind(self, name: str, where: str) -> Kind:
        kind = self.dataset.kinds.get(name)
        if kind is None:
            known = ", ".join(self.dataset.kinds)
            raise FormatError(f"there is no kind {name!r}", where=where, fix=f"use one of {known}")
        if kind.heights[0] >= kind.heights[1]:
            raise FormatError(
                f"the kind {name!r} has no height", where=where, fix="correct its heights"
            )
        return kind

    def deck(self, carrier: str | None, where: str) -> float:
        """Height of the deck of an object; of the ground if there is none."""
        if carrier is None:
            return 0.0
        below = self.scenario.objects.get(carrier)
        if below is None:
            raise FormatError(f"there is no object {carrier!r}", where=where, fix="correct the id")
        return self.kind(below.kind, where).heights[1]

    def solid(
        self, name: str, kind: Kind, at: Point, yaw_deg: float, *, lift: float, middle: bool = True
    ) -> PhysicalObject:
        """An object at rest, its pose at half its height or on the ground."""
        low, high = (height + lift for height in kind.heights)
        x, y = self.in_map(at)
        z = (low + high) / 2 if middle else low
        prism = Prism(self.footprint(at, yaw_deg, kind.size, f"{name}: size"), low, high)
        yaw = np.deg2rad(self.site.yaw_deg + yaw_deg)
        pose = Trajectory(t=[self.start_s], xyz=[[x, y, z]], yaw=[yaw])  # type: ignore[arg-type]
        return PhysicalObject(name, kind.labels, prism, pose)

    def in_map(self, at: Point) -> Point:
        x, y = _rotated(at, self.site.yaw_deg)
        return x + self.site.at[0], y + self.site.at[1]

    def footprint(self, at: Point, yaw_deg: float, size: Point, where: str) -> FloatArray:
        """Corners of a rectangle in the map, counter-clockwise, shape (4, 2)."""
        if min(size) <= 0:
            raise FormatError(f"the size {size} has no area", where=where, fix="correct it")
        x, y = self.in_map(at)
        corners = [
            _rotated((a * size[0] / 2, b * size[1] / 2), self.site.yaw_deg + yaw_deg)
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))
        ]
        moved: FloatArray = np.array(corners) + np.array([x, y])
        return moved


def build_world(dataset: Dataset, scenario: Scenario, start_s: float) -> World:
    """Set a scenario up and let its action happen.

    Parameters
    ----------
    start_s
        When its log starts. Logs of different scenarios must not overlap in time:
        whether two things moved together is seen from their clocks.

    Raises
    ------
    FormatError
        If the scenario refers to what isn't there, or its action can't be done; ``where``
        is the field.
    """
    site = dataset.sites.get(scenario.site)
    if site is None:
        raise FormatError(
            f"there is no site {scenario.site!r}",
            where="site",
            fix=f"use one of {', '.join(dataset.sites)}",
        )
    carried = scenario.robot.carries
    if carried is not None and carried not in scenario.objects:
        raise FormatError(
            f"there is no object {carried!r}", where="robot.carries", fix="correct the id"
        )
    builder = _Builder(dataset, scenario, site, start_s)
    before, places = builder.context(), builder.places()
    outcome = _perform(scenario.action, before, places)
    log = {item.id: item for item in (*outcome.objects, outcome.agent)}
    objects = tuple(log[item.id] for item in before.objects)
    target = scenario.action.pick_up or scenario.action.carry or scenario.action.put_down
    return World(
        scenario,
        replace(before, objects=objects),
        places,
        moved=log[target] if target else None,
    )


def _perform(action: Action, context: Context, places: dict[str, Place]) -> Outcome:
    objects = {item.id for item in context.objects if item.id != context.agent_id}

    def known(name: str, ids: Container[str], field: str) -> str:
        if name not in ids:
            raise FormatError(
                f"there is no {name!r}", where=f"action.{field}", fix="correct the id"
            )
        return name

    def prism(name: str, field: str) -> Prism:
        return places[known(name, places, field)].prism

    try:
        match action:
            case Action(str(place), None, None, None, None, None):
                return drive_to(context, prism(place, "drive_to"), gap_m=None)
            case Action(None, str(item), None, None, None, None):
                return pick_up(context, known(item, objects, "pick_up"))
            case Action(None, None, str(item), str(place), None, None):
                return carry(context, known(item, objects, "carry"), prism(place, "to"))
            case Action(None, None, None, None, str(item), str(place)):
                return put_down(context, known(item, objects, "put_down"), prism(place, "at"))
    except ValueError as error:
        raise FormatError(
            f"the action can't be done: {error}", where="action", fix="correct the scenario"
        ) from error
    raise FormatError(
        "this is not an action",
        where="action",
        fix="use drive_to; pick_up; carry and to; or put_down and at",
    )


def _rotated(point: Point, degrees: float) -> Point:
    angle = np.deg2rad(degrees)
    c, s = float(np.cos(angle)), float(np.sin(angle))
    return c * point[0] - s * point[1], s * point[0] + c * point[1]
