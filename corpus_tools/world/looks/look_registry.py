"""The registry of looks."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import mujoco
import numpy as np

from corpus_tools.world.looks.atlas import colour
from corpus_tools.world.looks.drawing import draw
from corpus_tools.world.looks.parts import box
from corpus_tools.world.state.shapes import Shape
from g3.registry import Registry

Look: TypeAlias = Callable[[mujoco.MjSpec, mujoco.MjsBody, Shape, float], None]
"""Adds geoms to a body of a world so that they fill the box. The number is the height of the
ground in the body's frame."""

LOOKS: Registry[Look] = Registry("look", "ct.looks")

_THINNEST_M = 0.02


def look(kind: str) -> Callable[[Look], Look]:
    """Register what a kind of object looks like. Flat boxes come to it with some thickness.

    Raises
    ------
    ValueError
        If the kind has another look.
    """

    def register(function: Look) -> Look:
        def fitted(
            spec: mujoco.MjSpec, body: mujoco.MjsBody, shape: Shape, ground_m: float
        ) -> None:
            function(spec, body, _thickened(shape), ground_m)

        LOOKS.add(fitted, kind)
        return function

    return register


def look_of(kind: str) -> Look:
    """The look of a kind; a plain block if none is registered."""
    return LOOKS.get(kind, plain)


def plain(spec: mujoco.MjSpec, body: mujoco.MjsBody, shape: Shape, ground_m: float) -> None:
    """A grey block."""
    shape = _thickened(shape)
    draw(spec, body, [box(shape.low, shape.high, colour("steel", 0.6, 1.0))])


def _thickened(shape: Shape) -> Shape:
    more = np.maximum(_THINNEST_M - shape.size, 0) / 2
    return Shape(shape.low - more, shape.high + more)
