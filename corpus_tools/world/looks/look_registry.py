"""The registry of looks."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeAlias

import mujoco
import numpy as np

from corpus_tools.world.looks.atlas import colour
from corpus_tools.world.looks.drawing import draw, variation
from corpus_tools.world.looks.parts import Part, box
from corpus_tools.world.state.shapes import Shape
from g3.registry import Registry

Look: TypeAlias = Callable[[mujoco.MjSpec, mujoco.MjsBody, Shape, float], None]
"""Adds geoms to a body of a world so that they fill the box. The number is the height of the
ground in the body's frame."""
PartsOf: TypeAlias = Callable[[Shape, np.random.Generator], Iterable[Part]]
"""Gives the parts that fill a box; the generator is the same for the same name."""

LOOKS: Registry[Look] = Registry("look", "ct.looks")

_THINNEST_M = 0.02


def look(kind: str) -> Callable[[Look], Look]:
    """Register the look of a kind of object. Flat boxes come to it with some thickness.

    Raises
    ------
    ValueError
        If the kind has another look.
    """

    def register(function: Look) -> Look:
        LOOKS.add(lambda spec, body, shape, z: function(spec, body, _thickened(shape), z), kind)
        return function

    return register


def drawn(kind: str, *, gloss: bool = False) -> Callable[[PartsOf], PartsOf]:
    """Register the look of a kind of object that is one mesh, by its parts alone."""

    def register(parts: PartsOf) -> PartsOf:
        @look(kind)
        def whole(spec: mujoco.MjSpec, body: mujoco.MjsBody, shape: Shape, ground_m: float) -> None:
            draw(spec, body, parts(shape, variation(body)), gloss=gloss)

        return parts

    return register


def look_of(kind: str) -> Look:
    """Return the look of a kind; a plain block if none is registered."""
    return LOOKS.get(kind, plain)


def plain(spec: mujoco.MjSpec, body: mujoco.MjsBody, shape: Shape, ground_m: float) -> None:
    """Add a grey block."""
    shape = _thickened(shape)
    draw(spec, body, [box(shape.low, shape.high, colour("steel", 0.6, 1.0))])


def _thickened(shape: Shape) -> Shape:
    more = np.maximum(_THINNEST_M - shape.size, 0) / 2
    return Shape(shape.low - more, shape.high + more)
