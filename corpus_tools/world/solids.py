"""How objects collide and what they weigh."""

from __future__ import annotations

import mujoco

from corpus_tools.world.kinds import Kind
from corpus_tools.world.shapes import Shape

SOLID_GROUP = 3
"""Group of geoms that collide and aren't seen."""


def add_solid(body: mujoco.MjsBody, kind: Kind, shape: Shape) -> None:
    """Add the geoms that an object collides with."""
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=shape.middle,
        size=shape.size / 2,
        mass=300.0,
        group=SOLID_GROUP,
    )
