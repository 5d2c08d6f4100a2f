"""The forklift. It has the sizes of the robot's body, not those of its prism."""

from __future__ import annotations

import mujoco
import numpy as np

from corpus_tools.world.looks.atlas import colour, patch
from corpus_tools.world.looks.drawing import draw
from corpus_tools.world.looks.look_registry import look
from corpus_tools.world.looks.parts import Part, box, disc, extruded, rod, tapered, turned
from corpus_tools.world.looks.vehicles import wheel
from corpus_tools.world.state import dimensions as sizes
from corpus_tools.world.state.forklift_parts import FORKS
from corpus_tools.world.state.shapes import Shape

_YELLOW = colour("yellow", 0.7, 1.05)
_BLACK = colour("black", 0.8, 1.15)
_DARK = colour("dark", 0.7, 1.0)
_STEEL = colour("steel", 0.7, 1.05)
_FENDER = (
    [(-0.36, 0.3), (-0.3, 0.3), (-0.2, 0.56), (-0.24, 0.63)],
    [(-0.2, 0.56), (0.2, 0.56), (0.24, 0.63), (-0.24, 0.63)],
    [(0.3, 0.3), (0.36, 0.3), (0.24, 0.63), (0.2, 0.56)],
)
"""Outlines of a front fender, x and z."""
(_REAR, _FRONT), (_RIGHT, _LEFT), (_BOTTOM, _TOP) = sizes.CHASSIS


@look("forklift")
def forklift(spec: mujoco.MjSpec, body: mujoco.MjsBody, shape: Shape, ground_m: float) -> None:
    """Add a counterbalanced forklift without a driver."""
    draw(spec, body, [*_hull(), *_seat(), *_guard(), *_rails(), *_wheels()], gloss=True)
    forks = next(child for child in body.bodies if child.name == FORKS)
    draw(spec, forks, [*_carriage(), *_tines()])


def _hull() -> list[Part]:
    """Build counterweight, bonnet, floor and dashboard."""
    lamp = colour("red", 1.0, 1.1)
    rear = _REAR + 0.03
    weight = [(rear + 0.08, 0.22), (-0.62, 0.22), (-0.62, 1.0)]
    weight += [(rear + 0.06, 0.97), (rear, 0.84), (rear, 0.4)]
    bonnet = [(-0.64, 0.3), (-0.16, 0.3), (-0.2, 0.78), (-0.64, 0.84)]
    cowl = [(0.16, 0.2), (_FRONT - 0.02, 0.2), (_FRONT - 0.04, 0.9), (0.26, 0.98)]
    parts = [
        extruded(weight, (-0.5, 0.5), _YELLOW),
        box((rear - 0.012, -0.47, 0.46), (rear, 0.47, 0.62), patch("hazard", t=(0, 0.25))),
        box((-0.95, -0.3, 0.96), (-0.66, 0.3, 1.0), _BLACK),
        extruded(bonnet, (-0.46, 0.46), _DARK),
        box((-0.62, -0.5, 0.16), (0.3, 0.5, 0.3), _BLACK),
        box((-0.14, -0.46, 0.3), (0.2, 0.46, 0.315), patch("plate", t=(0, 0.4)), without="-z"),
        extruded(cowl, (-0.44, 0.44), _YELLOW),
    ]
    for side in (-1, 1):
        y = side * 0.5
        parts.append(box((-0.6, y - 0.025, 0.2), (-0.18, y + 0.025, 0.5), _YELLOW))
        between = min(side * 0.36, side * 0.55), max(side * 0.36, side * 0.55)
        parts += [extruded(piece, between, _YELLOW) for piece in _FENDER]
        parts.append(
            box((rear - 0.015, side * 0.4 - 0.07, 0.69), (rear, side * 0.4 + 0.07, 0.77), lamp)
        )
    return parts


def _seat() -> list[Part]:
    """Build seat and steering wheel."""
    cushion = colour("black", 0.9, 1.15)
    wheel_at, half_spoke = np.array([0.08, 0.0, 1.12]), np.array([0.14, 0.015, 0.01])
    ring = [(0.135, -0.015), (0.165, -0.015), (0.165, 0.015), (0.135, 0.015), (0.135, -0.015)]
    return [
        tapered((-0.62, -0.26, 0.82), (-0.18, 0.26, 0.94), (-0.6, -0.22), (-0.2, 0.22), cushion),
        tapered((-0.68, -0.25, 0.86), (-0.54, 0.25, 1.42), (-0.76, -0.2), (-0.66, 0.2), cushion),
        rod((0.28, 0.0, 0.92), wheel_at, 0.03, _BLACK),
        turned(ring, _BLACK, centre=wheel_at, segments=12),
        box(wheel_at - half_spoke, wheel_at + half_spoke, _BLACK),
    ]


def _guard() -> list[Part]:
    """Build the overhead guard on four posts, with headlamps and a beacon."""
    roof = _TOP - 0.1
    front, back, half = 0.26, -0.82, 0.46
    parts = []
    for y in (-half, half):
        parts.append(rod((0.36, y, 0.5), (front, y, roof), 0.035, _BLACK))
        parts.append(rod((-0.98, y, 0.9), (back, y, roof), 0.035, _BLACK))
        parts.append(
            box((back - 0.04, y - 0.04, roof - 0.05), (front + 0.04, y + 0.04, roof + 0.02), _BLACK)
        )
        parts.append(box((front, y - 0.06, 1.66), (front + 0.1, y + 0.06, 1.78), _BLACK))
        lamp = (front + 0.102, y, 1.72)
        parts.append(disc(lamp, 0.055, colour("lamp"), facing="+x", segments=10))
    for x in (back, front):
        parts.append(box((x - 0.04, -half, roof - 0.05), (x + 0.04, half, roof + 0.02), _BLACK))
    for y in np.linspace(-half, half, 8)[1:-1]:
        parts.append(box((back, y - 0.016, roof - 0.03), (front, y + 0.016, roof + 0.01), _BLACK))
    at = (back + 0.05, 0.3, roof + 0.02)
    beacon = [(0.05, 0.0), (0.05, 0.05), (0.03, 0.08), (0.0, 0.08)]
    parts.append(turned(beacon, colour("amber", 1.0, 1.1), centre=at, segments=8))
    return parts


def _rails() -> list[Part]:
    """Build the fixed stage of the mast."""
    parts = []
    for side in (-1, 1):
        inner, outer = side * 0.31, side * 0.38
        parts.append(box((_FRONT + 0.01, inner, 0.08), (sizes.HEEL_X - 0.05, outer, _TOP), _DARK))
        lift = [(0.035, 0.15), (0.035, 1.1), (0.0, 1.1)]
        parts.append(turned(lift, _STEEL, centre=(_FRONT + 0.03, side * 0.2, 0), segments=8))
        parts.append(
            rod((0.1, side * 0.345, 0.32), (_FRONT + 0.02, side * 0.345, 0.95), 0.04, _STEEL)
        )
    for z in (0.12, 0.7, _TOP - 0.1):
        parts.append(box((_FRONT, -0.31, z), (_FRONT + 0.035, 0.31, z + 0.08), _DARK))
    return parts


def _wheels() -> list[Part]:
    axles = ((0.0, 0.43, 0.27, 0.22), (-0.86, 0.44, 0.22, 0.18))
    return [wheel((x, s * y, r), r, width, s) for s in (-1, 1) for x, y, r, width in axles]


def _carriage() -> list[Part]:
    """Build the parts that go up with the forks: inner stage of the mast, carriage and its rest."""
    floor, rest = -sizes.LOW + 0.06, sizes.BACKREST[2][1]
    parts = [box((-0.13, -0.3, 1.82), (-0.06, 0.3, 1.9), _STEEL)]
    for side in (-1, 1):
        parts.append(box((-0.13, side * 0.235, floor), (-0.06, side * 0.3, 1.9), _STEEL))
    for z in (0.1, 0.42):
        parts.append(box((-0.08, -0.46, z), (-0.04, 0.46, z + 0.09), _BLACK))
    for y in np.linspace(-0.44, 0.44, 7):
        parts.append(box((-0.065, y - 0.014, 0.42), (-0.04, y + 0.014, rest), _BLACK))
    parts.append(box((-0.07, -0.455, rest - 0.05), (-0.035, 0.455, rest), _BLACK))
    return parts


def _tines() -> list[Part]:
    """Build two forks, thin at their tips."""
    steel, half = colour("steel", 0.55, 0.85), sizes.FORK_WIDTH / 2
    long, thick = sizes.FORK_LENGTH, sizes.FORK_THICKNESS
    tine = [(0.0, -thick), (0.7 * long, -thick), (long, -0.3 * thick), (long, 0.0), (0.0, 0.0)]
    parts = []
    for y in (-sizes.FORK_Y, sizes.FORK_Y):
        parts.append(extruded(tine, (y - half, y + half), steel))
        parts.append(box((-0.045, y - half, -thick), (0.0, y + half, 0.52), steel))
    return parts
