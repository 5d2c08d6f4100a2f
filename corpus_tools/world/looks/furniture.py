"""Things that stand around: shelves, barrels, cones, and what has no look of its own."""

from __future__ import annotations

import mujoco
import numpy as np

from corpus_tools.world.looks.atlas import board, colour, patch
from corpus_tools.world.looks.drawing import draw, variation
from corpus_tools.world.looks.look_registry import look
from corpus_tools.world.looks.pallets import cartons
from corpus_tools.world.looks.parts import Part, box, disc, rod, turned
from corpus_tools.world.state.shapes import Shape
from g3.groundings import FloatArray


@look("shelf")
def shelf(spec: mujoco.MjSpec, body: mujoco.MjsBody, shape: Shape, ground_m: float) -> None:
    """A rack with three floors of goods."""
    rng = variation(body)
    low, high = shape.low, shape.high
    post = np.minimum(0.09, 0.1 * shape.size[:2])
    beam = min(0.11, 0.04 * float(shape.size[2]))
    blue, orange = colour("blue", 0.75, 1.05), colour("orange", 0.95, 1.0)
    parts = []
    for x in (low[0], high[0] - post[0]):
        for y in (low[1], high[1] - post[1]):
            parts.append(
                box((x, y, low[2]), (x + post[0], y + post[1], high[2]), blue, without="-z")
            )
        for k in range(4):
            z = low[2] + shape.size[2] * (np.array([k, k + 1]) / 4.2 + 0.02)
            ends = (low[1] + post[1] / 2, high[1] - post[1] / 2)
            a, b = ends if k % 2 else ends[::-1]
            parts.append(
                rod(
                    (x + post[0] / 2, a, z[0]),
                    (x + post[0] / 2, b, z[1]),
                    0.3 * float(post.min()),
                    blue,
                    segments=4,
                )
            )
    floors = low[2] + shape.size[2] * np.array([0.04, 0.38, 0.71])
    side = np.array([post[0], 0.0])
    inner_low, inner_high = low[:2] + side, high[:2] - side
    for i, z in enumerate(floors):
        top = floors[i + 1] - beam if i + 1 < len(floors) else high[2]
        for y in (low[1], high[1] - 0.5 * post[1]):
            parts.append(
                box((inner_low[0], y, z - beam), (inner_high[0], y + 0.5 * post[1], z), orange)
            )
        parts.append(
            box(
                (*inner_low, z - 0.02 * beam),
                (*inner_high, z),
                board(i),
                along=True,
                without="-x +x -y +y",
            )
        )
        parts += _goods(np.array([*inner_low, z]), np.array([*inner_high, top]), i, rng)
    draw(spec, body, parts)


def _goods(low: FloatArray, high: FloatArray, floor: int, rng: np.random.Generator) -> list[Part]:
    """What stands on a floor of a rack, in bays a metre wide."""
    size = high - low
    bays = max(1, min(6, round(float(size[0]))))
    pitch = size[0] / bays
    parts: list[Part] = []
    for bay in range(bays):
        start = low + np.array([(bay + 0.06) * pitch, 0.08 * size[1], 0.0])
        height = size[2] * float(rng.choice([0.55, 0.75, 0.9]))
        end = np.array([start[0] + 0.88 * pitch, high[1] - 0.08 * size[1], low[2] + height])
        what = (bay + 2 * floor) % 3
        if what == 0:
            parts.append(box(start, end, patch("crate"), without="-z"))
        else:
            parts += cartons(start, end, rng)
    return parts


@look("barrel")
def barrel(spec: mujoco.MjSpec, body: mujoco.MjsBody, shape: Shape, ground_m: float) -> None:
    """A blue steel drum."""
    x, y, z = shape.middle[0], shape.middle[1], shape.low[2]
    radius, height = float(shape.size[:2].min()) / 2, float(shape.size[2])
    blue, rib = colour("blue", 0.7, 1.05), 0.955
    profile = [(0.0, 0.0), (0.97, 0.0), (1.0, 0.015), (0.97, 0.04), (rib, 0.05)]
    for middle in (0.34, 0.66):
        profile += [
            (rib, middle - 0.03),
            (1.0, middle - 0.012),
            (1.0, middle + 0.012),
            (rib, middle + 0.03),
        ]
    profile += [
        (rib, 0.95),
        (0.98, 0.965),
        (1.0, 0.985),
        (0.98, 1.0),
        (0.92, 1.0),
        (0.91, 0.97),
        (0.0, 0.97),
    ]
    parts = [
        turned(
            np.array(profile[1:-1]) * (radius, height),
            blue,
            centre=(x, y, z),
            segments=20,
            smooth=True,
        ),
        disc((x, y, z + 0.97 * height), 0.92 * radius, colour("blue", 0.85, 0.85), segments=20),
    ]
    for angle, size in ((0.6, 0.13), (3.6, 0.08)):
        at = (x + 0.6 * radius * np.cos(angle), y + 0.6 * radius * np.sin(angle), z + 0.97 * height)
        parts.append(
            turned(
                [(size * radius, 0), (size * radius, 0.018 * height)],
                colour("steel"),
                centre=at,
                segments=8,
            )
        )
        parts.append(
            disc((at[0], at[1], z + 0.988 * height), size * radius, colour("light"), segments=8)
        )
    draw(spec, body, parts, gloss=True)


@look("cone")
def cone(spec: mujoco.MjSpec, body: mujoco.MjsBody, shape: Shape, ground_m: float) -> None:
    """A traffic cone."""
    (x, y, _), (low, high) = shape.middle, (shape.low, shape.high)
    radius, height = 0.4 * float(shape.size[:2].min()), float(shape.size[2])
    foot = 0.06 * height
    profile = [(radius, 0.0), (0.16 * radius, height - foot)]
    top = (x, y, high[2])
    parts = [
        box(low, (high[0], high[1], low[2] + foot), colour("orange", 0.7, 0.9)),
        turned(profile, patch("cone"), centre=(x, y, low[2] + foot), segments=16),
        disc(top, 0.16 * radius, colour("dark"), segments=16),
    ]
    draw(spec, body, parts)


@look("other")
def other(spec: mujoco.MjSpec, body: mujoco.MjsBody, shape: Shape, ground_m: float) -> None:
    """A steel case with a darker rim."""
    low, high = shape.low, shape.high
    rim = 0.06 * shape.size * (0, 0, 1)
    parts = [
        box(low, (*high[:2], low[2] + rim[2]), colour("dark")),
        box(low + rim, high - rim, patch("plate"), without="-z +z"),
        box((*low[:2], high[2] - rim[2]), high, colour("dark", 0.8, 1.0), tops=patch("plate")),
    ]
    draw(spec, body, parts)
