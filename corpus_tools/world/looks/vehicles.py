"""Tyres and wheels, and vehicles with them: trucks, trailers and the forklift.

Boxes of trucks and trailers are their decks; cabs, drawbars and wheels reach out of them. The
forklift has the sizes of the robot's body, not those of its prism.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import mujoco
import numpy as np

from corpus_tools.world.looks.atlas import Finish, colour, patch
from corpus_tools.world.looks.drawing import draw
from corpus_tools.world.looks.look_registry import look
from corpus_tools.world.looks.parts import (
    Part,
    Point,
    box,
    disc,
    extruded,
    inside,
    join,
    mirrored,
    quad,
    rod,
    tapered,
    turned,
)
from corpus_tools.world.looks.people import driver
from corpus_tools.world.state import dimensions as sizes
from corpus_tools.world.state.dimensions import CAB_TOP
from corpus_tools.world.state.forklift_parts import FORKS
from corpus_tools.world.state.shapes import Shape
from corpus_tools.world.state.solids import deck_of
from corpus_tools.world.state.thing_kinds import TRUCK
from g3.groundings import FloatArray

DRAWBAR_LENGTH = 0.75
"""Length of a trailer's drawbar ahead of it."""

_DARK = colour("dark", 0.6, 0.9)


@look("trailer")
def trailer(spec: mujoco.MjSpec, body: mujoco.MjsBody, shape: Shape, ground_m: float) -> None:
    """Add a flat deck of planks on two axles, with a drawbar."""
    low, high = shape.low, shape.high
    length, width, _ = shape.size
    ground = _ground(shape, ground_m)
    middle = float(shape.middle[1])
    red = colour("red", 0.6, 0.95)
    floor = _deck(low, high, red)
    frame = high[2] - _deck_thickness(shape)
    hitch = min(DRAWBAR_LENGTH, 0.3 * float(length))
    z = ground + 0.6 * (frame - ground)
    tip = (high[0] + hitch, middle, z)
    eye = [(0.05, -0.04), (0.11, -0.04), (0.11, 0.04), (0.05, 0.04)]
    leg = high[0] - 0.05 * length
    parts = [
        *floor,
        *_beams((low[0], high[0]), middle, width, (max(frame - 0.16, ground), frame)),
        *_wheels([low[0] + part * length for part in (0.2, 0.37)], shape, ground, frame),
        *(
            rod((high[0] - 0.1 * hitch, middle + s * 0.3 * width, z), tip, 0.05, _DARK)
            for s in (-1, 1)
        ),
        turned(eye, _DARK, centre=tip, segments=10),
        rod((leg, middle, ground), (leg, middle, frame), 0.05, colour("steel")),
        box((leg - 0.12, middle - 0.12, ground), (leg + 0.12, middle + 0.12, ground + 0.03), _DARK),
        *_rear_lights(low[0], middle, width, frame - 0.02),
        *_tail(low[0], middle, width, (frame, float(high[2])), ground),
    ]
    draw(spec, body, parts)


LIVERIES = (("dark", "red"), ("teal", "blue"))
"""Colours of a truck's bed and cab."""


@look("flatbed-truck")
@look("truck")
def truck(spec: mujoco.MjSpec, body: mujoco.MjsBody, shape: Shape, ground_m: float) -> None:
    """Add a truck with a flat bed behind its cab; of two numbered ones each has its own livery."""
    livery = LIVERIES[sum(body.name.encode()) % len(LIVERIES)]
    bed, cab = _flatbed(shape, ground_m, (0.14, 0.29), *livery)
    draw(spec, body, bed)
    draw(spec, body, cab, gloss=True)


@look("semi-truck")
def semi_truck(spec: mujoco.MjSpec, body: mujoco.MjsBody, shape: Shape, ground_m: float) -> None:
    """Add a tractor with a flat semi-trailer; without it where the shape is too high for a deck."""
    if shape.size[2] > CAB_TOP:
        bed, cab = _tractor(shape, ground_m)
    else:
        bed, cab = _flatbed(shape, ground_m, (0.08, 0.2, 0.32), "dark", "white")
    draw(spec, body, bed)
    draw(spec, body, cab, gloss=True)


def _flatbed(
    shape: Shape, ground_m: float, rear_axles: Sequence[float], bed: str, paint: str
) -> tuple[list[Part], list[Part]]:
    """Build a flat bed, and the cab ahead of it."""
    low, high = shape.low, shape.high
    length, width, _ = shape.size
    middle = float(shape.middle[1])
    ground = _ground(shape, ground_m)
    frame = high[2] - _deck_thickness(shape)
    _, bed_end = deck_of(TRUCK, shape)
    axles = [low[0] + part * length for part in rear_axles]
    roof = max(ground + CAB_TOP, float(high[2]) + 0.8)
    cab = low + np.array([bed_end - low[0] + 0.02 * length, 0, 0]), high
    parts = [
        *_deck(low, np.array([bed_end, high[1], high[2]]), colour(bed, 0.6, 0.95)),
        *_headboard(bed_end, shape, roof),
        *_beams((low[0], bed_end), middle, width, (max(frame - 0.22, ground), frame)),
        *_wheels([*axles, high[0] - 0.13 * length], shape, ground, frame),
        *_rear_lights(low[0], middle, width, frame - 0.02),
        *_tank(float(low[0] + 0.56 * length), shape, ground, frame),
    ]
    return parts, _cab(*cab, ground, roof, paint)


def _tractor(shape: Shape, ground_m: float) -> tuple[list[Part], list[Part]]:
    """Build a fifth wheel on a frame, and a cab with a sleeper and a long bonnet."""
    low, high = shape.low, shape.high
    part, (length, width, height) = inside(low, high), shape.size.tolist()
    ground, frame = float(low[2]), float(low[2]) + 0.3 * height
    white, steel, silver = colour("white", 0.7, 1.05), colour("steel"), colour("silver", 0.6, 1.1)
    window, black = patch("window"), colour("black", 0.8, 1.1)
    fifth = [(0.0, 0.0), (0.17 * width, 0.0), (0.17 * width, 0.06), (0.0, 0.06)]
    plate = (float(low[0]) + 0.2 * length, float(shape.middle[1]), frame)
    paint = [
        part((0.4, 0.56), (0.03, 0.97), (0.3, 1.0), white, tops=white),
        part((0.56, 0.72), (0.05, 0.95), (0.2, 0.9), white, tops=white),
        part((0.72, 0.97), (0.14, 0.86), (0.24, 0.58), white, tops=white),
        part((0.96, 0.985), (0.14, 0.86), (0.2, 0.56), patch("grille")),
        part((0.7, 0.725), (0.09, 0.91), (0.6, 0.84), window, without="-x -y +y -z +z"),
        part((0.6, 0.7), (0.045, 0.955), (0.58, 0.82), window, without="-x +x -z +z"),
        part((0.76, 0.95), (0.0, 0.16), (0.24, 0.36), white, tops=white),
        part((0.76, 0.95), (0.84, 1.0), (0.24, 0.36), white, tops=white),
        part((0.97, 1.0), (0.04, 0.96), (0.08, 0.18), silver),
    ]
    rear = [
        *_beams((low[0], low[0] + 0.96 * length), plate[1], width, (frame - 0.1 * height, frame)),
        *_wheels([low[0] + at * length for at in (0.12, 0.27, 0.85)], shape, ground, frame),
        *_tank(float(low[0] + 0.5 * length), shape, ground, frame),
        turned(fifth, _DARK, centre=plate, segments=14),
        *(part((0.37, 0.39), y, (0.3, 0.98), silver) for y in ((0.06, 0.1), (0.9, 0.94))),
        *(part((0.0, 0.01), y, (0.06, 0.26), black) for y in ((0.02, 0.2), (0.8, 0.98))),
        part((0.3, 0.37), (0.3, 0.7), (0.28, 0.34), steel),
        *_rear_lights(low[0] + 0.02 * length, plate[1], width, frame - 0.02),
    ]
    return rear, paint


def _cab(low: FloatArray, high: FloatArray, ground: float, top: float, paint: str) -> list[Part]:
    """Build a cab over the front axle, from behind it to the front."""
    (back, right, _), (front, left, deck) = low, high
    bottom = ground + 0.3 * (deck - ground)
    part = inside(np.array((back, right, bottom)), np.array((front, left, top)))
    tall, length, coat = top - bottom, front - back, colour(paint, 0.62, 1.05)
    window, black, sides = patch("window"), colour("black", 0.8, 1.0), "-x +x -z +z"
    sill = (deck - bottom + 0.35 * (top - deck)) / tall
    arch, lean = 0.55 * (deck - bottom) / tall, 0.16
    wheel_end = min(0.53 + 0.45 / length, 0.9)
    outline = [(0, arch), (1, arch), (1, sill), (1 - lean, 1), (0, 1)]
    shell = [(back + x * length, bottom + z * tall) for x, z in outline]
    slant = np.array((shell[3][0], 0, shell[3][1])) - (front, 0, shell[2][1])
    out = 0.012 * np.array((slant[2], 0, -slant[0])) / np.hypot(slant[0], slant[2])
    ends = [(front, 0, shell[2][1]) + share * slant + out for share in (0.06, 0.86)]
    y = right + (left - right) * np.array((0.06, 0.94))
    glass = [(*ends[i][:1], y[j], ends[i][2]) for i, j in ((0, 0), (0, 1), (1, 1), (1, 0))]
    above = (sill, sill + 0.8 * (1 - sill))
    return [
        extruded(shell, (right + 0.02 * (left - right), left - 0.02 * (left - right)), coat),
        part((wheel_end, 1.0), (0.02, 0.98), (0.0, arch), coat, without="+z"),
        part((0.0, wheel_end), (0.3, 0.7), (0.0, arch), _DARK),
        part((0.99, 1.005), (0.02, 0.98), (0.0, 0.88 * sill), patch("grille"), without="-y +y -z"),
        quad(glass, window),
        part((0.22, 0.84), (0.015, 0.985), above, window, without=sides),
        part((-0.005, 0.01), (0.2, 0.8), above, window, without="-y +y -z +z"),
        part((0.24, 0.34), (0.01, 0.99), (sill - 0.1, sill - 0.07), black, without=sides),
        *(
            part((0.92, 0.96), side, (sill + 0.02, sill + 0.22), black)
            for side in ((-0.05, 0.02), (0.98, 1.05))
        ),
        *(
            part((0.78, 0.82), (at - 0.03, at + 0.03), (1.0, 1.02), colour("amber", 0.9, 1.1))
            for at in (0.12, 0.5, 0.88)
        ),
    ]


def _deck(low: FloatArray, high: FloatArray, finish: Finish) -> list[Part]:
    """Build a floor of planks, in lengths that keep the grain fine, with a rim and reflectors."""
    part, (length, width, _) = inside(low, high), (high - low).tolist()
    rim_x, rim_y = min(0.07, 0.1 * width) / length, min(0.07 / width, 0.1)
    planks, amber = patch("deck"), colour("amber", 0.9, 1.1)
    ends = np.linspace(rim_x, 1 - rim_x, max(1, min(4, round(length / 2))) + 1)
    return [
        part((0.0, 1.0), (0.0, 1.0), (0.6, 1.0), finish, tops=colour("light", 0.8, 0.8)),
        *(
            part(x, (rim_y, 1 - rim_y), (0.99, 1.003), planks, without="-x +x -y +y -z")
            for x in pairwise(ends)
        ),
        *(
            part((x - 0.01, x + 0.01), (-0.003, 1.003), (0.77, 0.83), amber, without="-z +z -x +x")
            for x in np.linspace(0.1, 0.9, 4)
        ),
    ]


def _deck_thickness(shape: Shape) -> float:
    return 0.4 * float(shape.size[2])


def _beams(
    x: tuple[float, float], middle: float, width: float, z: tuple[float, float]
) -> list[Part]:
    """Build two beams along the vehicle, below its deck."""
    half = 0.04 * width
    return [
        box((x[0], y - half, z[0]), (x[1], y + half, z[1]), _DARK, without="+z")
        for y in (middle - 0.22 * width, middle + 0.22 * width)
    ]


def _wheels(axles: list[float], shape: Shape, ground: float, frame: float) -> list[Part]:
    """Build wheels at both ends of the axles, below the deck."""
    room = frame - ground
    radius = 0.47 * room
    width = min(0.34, 0.16 * float(shape.size[1]))
    parts = []
    for x in axles:
        hub = ground + radius
        y = shape.low[1] + 0.03 + width / 2, shape.high[1] - 0.03 - width / 2
        parts.append(rod((x, y[0], hub), (x, y[1], hub), 0.06, _DARK))
        parts += [
            wheel((x, y_, hub), radius, width, side) for y_, side in zip(y, (-1, 1), strict=True)
        ]
    return parts


def _rear_lights(x: float, middle: float, width: float, top: float) -> list[Part]:
    """Build a bar with red and amber lamps at the rear."""
    low = np.array((x, middle - width / 2, top - min(0.12, 0.06 * width)))
    part = inside(low, np.array((x + 0.06, middle + width / 2, top)))
    lamps = ((0.06, "red"), (0.16, "amber"), (0.76, "amber"), (0.86, "red"))
    return [
        part((0.0, 1.0), (0.02, 0.98), (0.0, 1.0), _DARK),
        *(
            part((-0.2, 0.0), (y, y + 0.08), (0.1, 0.9), colour(name, 1.0, 1.1))
            for y, name in lamps
        ),
    ]


def _tail(
    x: float, middle: float, width: float, deck: tuple[float, float], ground: float
) -> list[Part]:
    """Build the rear of trailers: striped boards, red triangles, and mudflaps."""
    bottom, top = deck
    z, half = (bottom + 0.1 * (top - bottom), top - 0.1 * (top - bottom)), 0.32 * (deck[0] - ground)
    parts = []
    for side in (-1, 1):
        edge, inner = middle + side * 0.47 * width, middle + side * 0.24 * width
        ends = (min(edge, inner), max(edge, inner))
        stripes = patch("cone", t=(0.1, 0.9))
        parts.append(quad([(x - 0.012, y, h) for y, h in _turned_back(ends, z)], stripes))
        centre, base = middle + side * 0.12 * width, bottom - 0.02
        red = colour("red", 1.0, 1.1)
        corners = [(centre + half, base - 1.7 * half), (centre - half, base - 1.7 * half)]
        corners += [(centre, base), (centre, base)]
        parts.append(quad([(x - 0.02, y, h) for y, h in corners], red))
        flap = middle + side * (width / 2 - 0.22)
        low = (x + 0.02, flap - 0.16, ground + 0.06)
        parts.append(box(low, (x + 0.04, flap + 0.16, bottom), colour("black", 0.8, 1.0)))
    return parts


def _turned_back(y: tuple[float, float], z: tuple[float, float]) -> list[tuple[float, float]]:
    """Return the corners of a rectangle that faces backwards; its finish is on its side."""
    return [(y[1], z[1]), (y[1], z[0]), (y[0], z[0]), (y[0], z[1])]


def _headboard(x: float, shape: Shape, roof: float) -> list[Part]:
    """Build a steel wall between the bed and the cab."""
    low, high = shape.low[1] + 0.03, shape.high[1] - 0.03
    z = shape.high[2]
    return [
        box(
            (x, low, z - 0.1),
            (x + 0.05, high, z + 0.5 * (roof - z)),
            colour("steel", 0.7, 0.95),
            tops=_DARK,
        )
    ]


def _tank(x: float, shape: Shape, ground: float, frame: float) -> list[Part]:
    """Build fuel tanks on both sides."""
    radius = 0.3 * (frame - ground)
    half, silver = 0.07 * float(shape.size[0]), colour("silver", 0.55, 1.0)
    profile = [(0, -half), (radius, -half), (radius, half), (0, half)]
    return [
        turned(profile, silver, centre=(x, y, frame - radius), axis="x", segments=12)
        for y in (shape.low[1] + 1.3 * radius, shape.high[1] - 1.3 * radius)
    ]


def _ground(shape: Shape, ground_m: float) -> float:
    """Return the height of the ground, or where it would be under wheels of a likely size."""
    bottom = float(shape.low[2])
    return ground_m if 0.2 <= bottom - ground_m <= 1.2 else bottom - 0.45


_BEAD = 0.58
"""Radius of the hole, as a part of the tyre's."""
_SEGMENTS = 16


def tyre(bottom: Point, radius: float, width: float, *, open_top: bool) -> Part:
    """Build a tyre that lies on its side, with the middle of its lower side at `bottom`.

    `open_top` is true if its hole is seen; otherwise something lies on it.
    """
    profile = [(0.74, 0.0), (0.9, 0.05), (1.0, 0.2), (1.0, 0.8), (0.9, 0.95), (0.74, 1.0)]
    finish = patch("tyre", t=(0.14, 0.86))
    if open_top:
        profile.append((_BEAD, 0.88))
        finish = patch("tyre", t=(0.14, 1.0))
    rubber = np.array(profile) * (radius, width)
    parts = [turned(rubber, finish, centre=bottom, segments=_SEGMENTS, smooth=True)]
    if open_top:
        hole = [(_BEAD * radius, 0.88 * width), (_BEAD * radius, 0.1 * width)]
        x, y, z = bottom
        parts.append(turned(hole, colour("black", 0.35, 0.6), centre=bottom, segments=_SEGMENTS))
        floor = (x, y, z + 0.1 * width)
        parts.append(disc(floor, _BEAD * radius, colour("black", 0.35, 0.35), segments=_SEGMENTS))
    return join(parts)


def wheel(hub: Point, radius: float, width: float, side: int) -> Part:
    """Build a wheel that turns about y, with its middle at `hub`.

    `side` is 1 if its outside is on the left, -1 if it is on the right.
    """
    x, y, z = hub
    half = width / 2
    rim = 0.62 * radius
    profile = mirrored([(rim, -half), (0.93 * radius, -half), (radius, -0.6 * half)])
    facing = "+y" if side > 0 else "-y"
    rubber, outside = patch("tyre", t=(0.22, 0.78)), (x, y + side * (half - 0.015), z)
    return join(
        [
            turned(profile, rubber, centre=hub, axis="y", segments=_SEGMENTS, smooth=True),
            disc(outside, rim, patch("wheel"), facing=facing, segments=_SEGMENTS),
        ]
    )


_YELLOW = colour("yellow", 0.7, 1.05)
_BLACK = colour("black", 0.8, 1.15)
_IRON = colour("dark", 0.7, 1.0)
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
    """Add a counterbalanced forklift with its driver."""
    parts = [*_hull(), *_seat(), *_guard(), *_rails(), *_robot_wheels()]
    draw(spec, body, parts, gloss=True)
    draw(spec, body, driver((-0.52, 0.0, 0.92), _WHEEL))
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
        extruded(bonnet, (-0.46, 0.46), _IRON),
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


_WHEEL = (0.08, 0.0, 1.12)
"""Middle of the steering wheel."""


def _seat() -> list[Part]:
    """Build seat and steering wheel."""
    cushion = colour("black", 0.9, 1.15)
    wheel_at, half_spoke = np.array(_WHEEL), np.array([0.14, 0.015, 0.01])
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
        parts.append(box((_FRONT + 0.01, inner, 0.08), (sizes.HEEL_X - 0.05, outer, _TOP), _IRON))
        lift = [(0.035, 0.15), (0.035, 1.1), (0.0, 1.1)]
        parts.append(turned(lift, _STEEL, centre=(_FRONT + 0.03, side * 0.2, 0), segments=8))
        parts.append(
            rod((0.1, side * 0.345, 0.32), (_FRONT + 0.02, side * 0.345, 0.95), 0.04, _STEEL)
        )
    for z in (0.12, 0.7, _TOP - 0.1):
        parts.append(box((_FRONT, -0.31, z), (_FRONT + 0.035, 0.31, z + 0.08), _IRON))
    return parts


def _robot_wheels() -> list[Part]:
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
