"""The look of a cable reel."""

from __future__ import annotations

import mujoco
import numpy as np

from corpus_tools.world.looks.atlas import board, colour
from corpus_tools.world.looks.drawing import draw
from corpus_tools.world.looks.look_registry import look
from corpus_tools.world.looks.parts import box, disc, rod
from corpus_tools.world.state.dimensions import ENTRY_HEIGHT, PALLET_HEIGHT
from corpus_tools.world.state.shapes import Shape

FLANGE_M = 0.06
FOOT_M = 0.1


@look("cable-reel")
def cable_reel(spec: mujoco.MjSpec, body: mujoco.MjsBody, shape: Shape, ground_m: float) -> None:
    """Two round flanges with cable between, across a pallet."""
    (x0, y0, z0), (x1, y1, z1) = shape.low, shape.high
    bottom = z0 + PALLET_HEIGHT
    middle = np.array([(x0 + x1) / 2, (bottom + z1) / 2])
    radius = min(x1 - x0, z1 - bottom) / 2
    wood, cable = colour("wood", 0.7, 1.0), colour("rubber", 0.6, 1.0)
    parts = [box((x0, y0, z0 + ENTRY_HEIGHT), (x1, y1, bottom), board(0), along=True)]
    for y in (y0, (y0 + y1 - FOOT_M) / 2, y1 - FOOT_M):
        parts.append(box((x0, y, z0), (x1, y + FOOT_M, z0 + ENTRY_HEIGHT), board(1), along=True))
    for y in (y0, y1 - FLANGE_M):
        ends = ((middle[0], y, middle[1]), (middle[0], y + FLANGE_M, middle[1]))
        parts.append(rod(*ends, radius, wood, segments=20))
        parts += [
            disc(end, radius, wood, facing=facing, segments=20)
            for end, facing in zip(ends, ("-y", "+y"), strict=True)
        ]
    inner = ((middle[0], y0 + FLANGE_M, middle[1]), (middle[0], y1 - FLANGE_M, middle[1]))
    parts.append(rod(*inner, 0.75 * radius, cable, segments=20))
    draw(spec, body, parts)
