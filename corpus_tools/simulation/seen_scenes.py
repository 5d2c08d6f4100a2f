"""Scenes as a simulated worker sees them: positions of things relative to the robot, and events."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from corpus_tools.world.scenarios.contexts import scenario_context
from corpus_tools.world.scenarios.scenario import ROBOT, Scenario
from corpus_tools.world.state.thing_kinds import KINDS
from g3.geometry.plane import rotate
from g3.groundings import Colour, FloatArray, Prism
from g3.short_repr import short_repr


@short_repr
@dataclass(frozen=True, slots=True)
class Seen:
    """A thing or a place as the robot's driver sees it at the start."""

    id: str
    kind: str
    """Kind of a thing; empty for a place."""
    labels: frozenset[str]
    name: str
    """Name of a place on the map."""
    deck: str
    """Id of its support; empty for the ground."""
    at: tuple[float, float]
    """Metres ahead of the robot and to its left."""
    height: float
    colours: tuple[Colour, ...] = ()
    """Colours of its paint; none for the usual look of its kind."""


@short_repr
@dataclass(frozen=True, slots=True)
class Scene:
    """All that can be seen, by id."""

    scenario: Scenario
    things: Mapping[str, Seen]
    places: Mapping[str, Seen]
    """Things and places in view; the robot's load is not among the things."""


def see(scenario: Scenario) -> Scene:
    """Return a scenario as it looks from the robot's start."""
    context = scenario_context(scenario)
    start = context.agent.trajectory
    pose = (start.xyz[0, :2], float(start.yaw[0]))
    objects, regions = scenario.all_objects, scenario.all_places
    things = {
        item.id: Seen(
            item.id,
            objects[item.id].kind,
            frozenset(KINDS[objects[item.id].kind].labels),
            "",
            objects[item.id].deck or "",
            _from(pose, item.prism),
            item.prism.z_max - item.prism.z_min,
            item.colours,
        )
        for item in context.objects
        if item.id not in (ROBOT, scenario.robot.carries)
    }
    places = {
        name: Seen(
            name,
            "",
            frozenset(),
            regions[name].name,
            regions[name].deck or "",
            _from(pose, place),
            place.z_max - place.z_min,
        )
        for name, place in zip(regions, (p.prism for p in context.places), strict=True)
    }
    return Scene(scenario, things, places)


def distance(a: Seen, b: Seen) -> float:
    """Return the distance between the middles of two things, in metres."""
    return float(np.hypot(a.at[0] - b.at[0], a.at[1] - b.at[1]))


def _from(pose: tuple[FloatArray, float], prism: Prism) -> tuple[float, float]:
    position, yaw = pose
    ahead, left = rotate(prism.xy.mean(axis=0) - position, np.asarray(-yaw))
    return float(ahead), float(left)
