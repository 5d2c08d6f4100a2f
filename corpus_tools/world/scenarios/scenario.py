"""What a scenario holds.

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
    """An object.

    Parameters
    ----------
    kind
        One of :data:`corpus_tools.world.state.thing_kinds.KINDS`.
    at
        Where it is; None for what the robot carries.
    yaw_deg
        Its heading, relative to the robot's for what the robot carries.
    deck
        Id of the object on whose deck it stands; None for the ground.
    liftable
        Whether the robot may lift it; None where its kind decides.
    colours
        What it is painted, the main colour first; none for what its kind looks like, which no
        command can name.
    """

    kind: str
    at: Point | None = None
    yaw_deg: float = 0.0
    deck: str | None = None
    liftable: bool | None = None
    colours: tuple[Colour, ...] = ()


def may_be_lifted(thing: Thing) -> bool:
    """Whether the robot can lift a thing of a known kind, and nothing is said against it."""
    return KINDS[thing.kind].carriable and thing.liftable is not False


class Region(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A place.

    Parameters
    ----------
    at, yaw_deg
        Its middle and the direction of its first side.
    size
        Along and across that direction, in metres.
    deck
        Id of the object on whose deck it is; None for the ground.
    name
        What the map calls it; empty if it isn't on the map.
    """

    at: Point
    size: Size = (2.0, 2.0)
    yaw_deg: float = 0.0
    deck: str | None = None
    name: str = ""


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
    """A site: what is the same in all of its scenarios.

    Parameters
    ----------
    name
        Name of its file without the ending.
    title
        What it is, in a few words.
    at, yaw_deg
        Where its frame lies in the frame of its map.
    bounds
        Where things can be.
    objects, places
        By id.
    site
        What is around: an open yard, the yard before a warehouse, or a hall.
    """

    name: str
    title: str
    at: Point
    yaw_deg: float
    bounds: Bounds
    objects: Mapping[str, Thing]
    places: Mapping[str, Region]
    site: SiteName = "yard"


@short_repr
@dataclass(frozen=True, slots=True)
class Scenario:
    """What stands where, and what the robot does.

    Parameters
    ----------
    id
        Name of its file without the ending.
    title
        What happens, in one sentence.
    objects, places
        What the scenario adds to the layout's, by id.
    """

    id: str
    title: str
    layout: Layout
    objects: Mapping[str, Thing]
    places: Mapping[str, Region]
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
