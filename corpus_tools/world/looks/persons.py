"""People."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from corpus_tools.world.looks.atlas import Finish, colour, patch
from corpus_tools.world.looks.look_registry import drawn
from corpus_tools.world.looks.parts import Part, ball, box, join, rod, turned
from corpus_tools.world.state.shapes import Shape

_SIZE = np.array([0.5, 0.5, 1.75])
"""Size of the person as drawn, before being fitted into a box."""


@drawn("person")
def person(shape: Shape, rng: np.random.Generator) -> list[Part]:
    """Build a worker with a warning vest and a hard hat, who looks ahead."""
    scale = shape.size / _SIZE
    figure = _figure()
    lengths = np.linalg.norm(figure.normal / scale, axis=1, keepdims=True)
    bottom = np.array([*shape.middle[:2], shape.low[2]])
    at, normal = figure.at * scale + bottom, figure.normal / scale / lengths
    return [replace(figure, at=at, normal=normal)]


def _figure() -> Part:
    denim, sleeve, skin = colour("denim", 0.7, 1.0), colour("navy", 0.85, 1.1), colour("skin")
    parts: list[Part] = []
    for side in (-1, 1):
        parts += [
            box((-0.09, side * 0.10 - 0.05, 0), (0.19, side * 0.10 + 0.05, 0.09), colour("brown")),
            rod((0, side * 0.10, 0.07), (0, side * 0.10, 0.5), (0.058, 0.066), denim, segments=8),
            rod((0, side * 0.10, 0.5), (0, side * 0.088, 0.92), (0.066, 0.088), denim, segments=8),
            ball((-0.01, side * 0.178, 1.395), (0.06, 0.066, 0.06), sleeve, segments=8),
            rod((-0.01, side * 0.195, 1.41), (-0.02, side * 0.215, 1.14), (0.052, 0.043), sleeve),
            rod((-0.02, side * 0.215, 1.14), (0.07, side * 0.205, 0.9), (0.043, 0.034), sleeve),
            ball((0.085, side * 0.203, 0.865), (0.04, 0.03, 0.055), skin, segments=6),
        ]
    torso = [(0.112, 0.82), (0.116, 1.0), (0.128, 1.25), (0.125, 1.38), (0.098, 1.45), (0.05, 1.48)]
    parts += [
        turned(torso, patch("vest"), segments=12, smooth=True, squash=1.5),
        rod((0.0, 0.0, 1.45), (0.01, 0.0, 1.54), 0.05, skin),
        ball((0.015, 0.0, 1.6), (0.092, 0.078, 0.115), skin, segments=10),
        *_hat(colour("yellow", 0.85, 1.05)),
    ]
    for side in (-1, 1):
        y = side * 0.034
        parts.append(box((0.086, y - 0.012, 1.597), (0.104, y + 0.012, 1.615), colour("black")))
    return join(parts)


def _hat(finish: Finish) -> list[Part]:
    dome = [(0.108, 0.0), (0.108, 0.03), (0.094, 0.075), (0.06, 0.105), (0.0, 0.115)]
    brim = [(0.0, -0.008), (0.122, -0.008), (0.122, 0.008), (0.0, 0.008)]
    return [
        turned(dome, finish, centre=(0.01, 0.0, 1.635), segments=12, smooth=True, squash=0.9),
        turned(brim, finish, centre=(0.035, 0.0, 1.64), segments=12, squash=0.86),
    ]
