"""Small worlds for tests of the physics."""

from __future__ import annotations

import numpy as np

from corpus_tools.world.state.thing_kinds import KINDS
from g3.actions.courses import direction
from g3.groundings import Context, PhysicalObject, Prism
from tests.worlds import place, rectangle, still

TURNED = 0.4
"""Heading of what stands askew."""


def thing(
    name: str, kind: str, xy: tuple[float, float], yaw: float = 0.0, z: float = 0.0
) -> PhysicalObject:
    """An object of a kind that stands at a height."""
    looks = KINDS[kind]
    footprint = rectangle(xy, looks.size, yaw, looks.ahead_m)
    prism = Prism(footprint, z + looks.heights[0], z + looks.heights[1])
    return PhysicalObject(name, looks.labels or ("thing",), prism, still(*xy, z, yaw))


def on_deck(carrier: PhysicalObject, along: float, across: float) -> tuple[float, float]:
    """A point of a deck, told along and across its heading."""
    pose, yaw = carrier.trajectory.xyz[0, :2], carrier.trajectory.yaw[0]
    x, y = pose + along * direction(yaw) + across * direction(yaw + np.pi / 2)
    return float(x), float(y)


def yard(*more: PhysicalObject, robot: tuple[float, float, float] = (0.0, 0.0, 0.3)) -> Context:
    """A truck, a trailer, tires on the ground and boxes on the trailer, and places."""
    truck = thing("truck", "truck", (6.0, 7.0), TURNED)
    trailer = thing("trailer", "trailer", (-6.0, 6.0), 1.2)
    boxes = thing("boxes", "box-pallet", on_deck(trailer, 1.0, -0.5), 1.2 + np.pi / 2, 0.85)
    tires = thing("tires", "tire-pallet", (5.0, -2.0), 0.7)
    person = thing("person", "person", (2.0, 3.5))
    things = (truck, trailer, boxes, tires, person, *more)
    agent = thing("robot", "forklift", robot[:2], robot[2])
    places = (
        place("receiving", (-4.0, -4.0), (3.0, 2.0), 0.2),
        place("spot", (0.5, -5.0), yaw=0.3),
        place("truck bed", on_deck(truck, -1.0, -0.6), yaw=TURNED, z=1.0),
        place("trailer bed", on_deck(trailer, -1.0, -0.5), yaw=1.2, z=0.85),
        place("cab", on_deck(truck, 2.3, -0.6), yaw=TURNED, z=1.0),
    )
    return Context("yard", (*things, agent), places, "robot")
