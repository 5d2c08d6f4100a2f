"""People: a worker who stands, and the seated driver of a forklift."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np

from corpus_tools.world.looks.atlas import Finish, colour, patch
from corpus_tools.world.looks.drawing import draw
from corpus_tools.world.looks.look_registry import look
from corpus_tools.world.looks.parts import Part, Point, ball, box, join, moved, rod, turned
from corpus_tools.world.state.shapes import Shape

_SIZE = np.array([0.5, 0.5, 1.75])
"""Size of the person as drawn, before being fitted into a box."""
_HIP_M = 0.92
"""Height of the hips, on that scale."""
_DENIM, _SLEEVE = colour("denim", 0.7, 1.0), colour("navy", 0.85, 1.1)
_SKIN, _SHOE = colour("skin"), colour("brown")
_TORSO = (
    *((0.112, 0.82), (0.116, 1.0), (0.128, 1.25)),
    *((0.125, 1.38), (0.098, 1.45), (0.05, 1.48)),
)
"""Radii and heights of the torso."""


LEGS = ("left leg", "right leg")
"""Last words of the names of legs' bodies and joints, after that of the person's body."""


@look("person")
def person(spec: mujoco.MjSpec, body: mujoco.MjsBody, shape: Shape, ground_m: float) -> None:
    """Build a worker with a warning vest and a hard hat, who looks ahead; the legs swing."""
    scale = shape.size / _SIZE
    bottom = np.array([*shape.middle[:2], shape.low[2]])

    def fitted(parts: list[Part], hip: Point) -> Part:
        figure = moved(join(parts), tuple(-x for x in hip))
        lengths = np.linalg.norm(figure.normal / scale, axis=1, keepdims=True)
        return replace(figure, at=figure.at * scale, normal=figure.normal / scale / lengths)

    trunk = moved(fitted([*_hanging_arms(), *_upper_body()], (0, 0, 0)), tuple(bottom))
    draw(spec, body, [trunk])
    for name, y in zip(LEGS, (0.1, -0.1), strict=True):
        hip = (0.0, 0.88 * y, _HIP_M)
        # Bodies that joints move have a mass, though nothing here is moved by a force.
        leg = body.add_body(
            name=f"{body.name} {name}",
            pos=bottom + np.array(hip) * scale,
            explicitinertial=True,
            mass=1.0,
            inertia=[1.0, 1.0, 1.0],
        )
        leg.add_joint(name=leg.name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 1, 0])
        draw(spec, leg, [fitted(_leg(y), hip)])


def driver(seat: Point, wheel: Point) -> list[Part]:
    """Build a worker who sits, given the middle of the seat and of the steering wheel."""
    x, y, z = seat
    parts = [moved(join(_upper_body()), (x, y, z - _TORSO[0][1]))]
    for side in (-1, 1):
        hip, knee = (x + 0.04, y + side * 0.1, z + 0.07), (x + 0.42, y + side * 0.13, z + 0.08)
        ankle = (knee[0] + 0.08, knee[1], z - 0.5)
        shoulder, elbow = (x, y + side * 0.19, z + 0.57), (x + 0.16, y + side * 0.25, z + 0.33)
        hand = (wheel[0] - 0.06, wheel[1] + side * 0.14, wheel[2] + 0.03)
        parts += [
            rod(hip, knee, (0.088, 0.07), _DENIM, segments=8),
            rod(ankle, knee, (0.055, 0.068), _DENIM, segments=8),
            moved(box((-0.06, -0.05, -0.06), (0.2, 0.05, 0.02), _SHOE), ankle),
            ball(shoulder, (0.06, 0.066, 0.06), _SLEEVE, segments=8),
            rod(shoulder, elbow, (0.052, 0.043), _SLEEVE),
            rod(elbow, hand, (0.043, 0.034), _SLEEVE),
            ball(hand, (0.04, 0.035, 0.04), _SKIN, segments=6),
        ]
    return parts


def _leg(y: float) -> list[Part]:
    return [
        box((-0.09, y - 0.05, 0), (0.19, y + 0.05, 0.09), _SHOE),
        rod((0, y, 0.07), (0, y, 0.5), (0.058, 0.066), _DENIM, segments=8),
        rod((0, y, 0.5), (0, 0.88 * y, _HIP_M), (0.066, 0.088), _DENIM, segments=8),
    ]


def _hanging_arms() -> list[Part]:
    parts = []
    for side in (-1, 1):
        parts += [
            ball((-0.01, side * 0.178, 1.395), (0.06, 0.066, 0.06), _SLEEVE, segments=8),
            rod((-0.01, side * 0.195, 1.41), (-0.02, side * 0.215, 1.14), (0.052, 0.043), _SLEEVE),
            rod((-0.02, side * 0.215, 1.14), (0.07, side * 0.205, 0.9), (0.043, 0.034), _SLEEVE),
            ball((0.085, side * 0.203, 0.865), (0.04, 0.03, 0.055), _SKIN, segments=6),
        ]
    return parts


def _upper_body() -> list[Part]:
    """Build torso and head with its hat, without arms."""
    parts = [
        turned(_TORSO, patch("vest"), segments=12, smooth=True, squash=1.5),
        rod((0.0, 0.0, 1.45), (0.01, 0.0, 1.54), 0.05, _SKIN),
        ball((0.015, 0.0, 1.6), (0.092, 0.078, 0.115), _SKIN, segments=10),
        *_hat(colour("yellow", 0.85, 1.05)),
    ]
    for y in (-0.034, 0.034):
        parts.append(box((0.086, y - 0.012, 1.597), (0.104, y + 0.012, 1.615), colour("black")))
    return parts


def _hat(finish: Finish) -> list[Part]:
    dome = [(0.108, 0.0), (0.108, 0.03), (0.094, 0.075), (0.06, 0.105), (0.0, 0.115)]
    brim = [(0.0, -0.008), (0.122, -0.008), (0.122, 0.008), (0.0, 0.008)]
    return [
        turned(dome, finish, centre=(0.01, 0.0, 1.635), segments=12, smooth=True, squash=0.9),
        turned(brim, finish, centre=(0.035, 0.0, 1.64), segments=12, squash=0.86),
    ]
