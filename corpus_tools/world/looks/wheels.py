"""Tyres and wheels."""

from __future__ import annotations

import numpy as np

from corpus_tools.world.looks.atlas import colour, patch
from corpus_tools.world.looks.parts import Part, Point, disc, join, mirrored, turned

_BEAD = 0.58
"""Radius of the hole, as a part of the tyre's."""
_SEGMENTS = 16


def tyre(bottom: Point, radius: float, width: float, *, open_top: bool) -> Part:
    """A tyre that lies on its side, with the middle of its lower side at `bottom`.

    `open_top` says whether its hole is seen; otherwise something lies on it.
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
    """A wheel that turns about y, with its middle at `hub`.

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
