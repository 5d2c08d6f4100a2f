"""Contents of a scenario.

Positions are middles, in metres in the frame of the scenario's layout; headings are in
degrees counter-clockwise from its x axis, as people write them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

import msgspec

from corpus_tools.world.state.robot_script import Script
from corpus_tools.world.state.thing_kinds import KINDS
from g3.groundings import Colour
from g3.short_repr import short_repr

ROBOT = "forklift"
"""Id of the robot in every scenario."""

Point: TypeAlias = tuple[float, float]
Length: TypeAlias = Annotated[float, msgspec.Meta(gt=0)]
Size: TypeAlias = tuple[Length, Length]
SiteName: TypeAlias = Literal["yard", "depot", "hall"]


class Thing(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """An object."""

    kind: str
    """One of :data:`corpus_tools.world.state.thing_kinds.KINDS`."""
    at: Point | None = None
    """Position; None for the robot's load."""
    yaw_deg: float = 0.0
    """Heading, relative to the robot's for the robot's load."""
    deck: str | None = None
    """Id of the object on whose deck it stands; None for the ground."""
    liftable: bool | None = None
    """True if the robot may lift it; None where its kind decides."""
    colours: tuple[Colour, ...] = ()
    """Colours of its paint, the main one first; none for the usual look of its kind, which no
    command can name."""


def may_be_lifted(thing: Thing) -> bool:
    """Check that the robot can lift a thing of a known kind, and that it isn't ruled out."""
    return KINDS[thing.kind].carriable and thing.liftable is not False


class Region(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A place."""

    at: Point
    """Its middle."""
    size: Size = (2.0, 2.0)
    """Along and across the direction of its first side, in metres."""
    yaw_deg: float = 0.0
    """That direction."""
    deck: str | None = None
    """Id of the object on whose deck it is; None for the ground."""
    name: str = ""
    """Name on the map; empty if it isn't on the map."""


class Robot(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """The robot's first pose, and the id of what is on its forks."""

    at: Point
    yaw_deg: float = 0.0
    carries: str | None = None


class Bounds(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The rectangle that everything is in: from and to along each axis."""

    x: Point
    y: Point


@short_repr
@dataclass(frozen=True, slots=True)
class Layout:
    """A site: the common part of all of its scenarios."""

    name: str
    """Name of its file without the ending."""
    title: str
    """Description in a few words."""
    at: Point
    yaw_deg: float
    """Pose of its frame in the frame of its map."""
    bounds: Bounds
    """Bounds of things."""
    objects: Mapping[str, Thing]
    places: Mapping[str, Region]
    """By id."""
    site: SiteName = "yard"
    """Surroundings: an open yard, the yard before a warehouse, or a hall."""


@short_repr
@dataclass(frozen=True, slots=True)
class Scenario:
    """A layout with more objects and places, and the robot's script in it."""

    id: str
    """Name of its file without the ending."""
    title: str
    """Summary of the events, in one sentence."""
    layout: Layout
    objects: Mapping[str, Thing]
    places: Mapping[str, Region]
    """Objects and places that the scenario adds to the layout's, by id."""
    robot: Robot
    script: Script

    @property
    def all_objects(self) -> dict[str, Thing]:
        """The scenario's objects, then the layout's."""
        return {**self.objects, **self.layout.objects}

    @property
    def all_places(self) -> dict[str, Region]:
        """The scenario's places, then the layout's."""
        return {**self.places, **self.layout.places}
