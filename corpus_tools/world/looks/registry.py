"""The registry of looks."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import mujoco

from corpus_tools.world.shapes import Shape

Look: TypeAlias = Callable[[mujoco.MjsBody, Shape], None]
"""Adds geoms to a body so that they fill the box."""

_LOOKS: dict[str, Look] = {}

VISUAL_GROUP = 2
"""Group of geoms that are seen and don't collide."""


def look(kind: str) -> Callable[[Look], Look]:
    """Register what a kind of object looks like."""

    def register(function: Look) -> Look:
        if _LOOKS.setdefault(kind, function) is not function:
            raise ValueError(f"the kind {kind!r} has a look already")
        return function

    return register


def look_of(kind: str) -> Look:
    """The look of a kind; a plain block if none is registered."""
    return _LOOKS.get(kind, block)


def block(body: mujoco.MjsBody, shape: Shape) -> None:
    """A grey block."""
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=shape.middle,
        size=shape.size / 2,
        rgba=[0.6, 0.6, 0.62, 1],
        group=VISUAL_GROUP,
        contype=0,
        conaffinity=0,
        mass=0,
    )
