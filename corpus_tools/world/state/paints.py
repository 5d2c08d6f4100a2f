"""Values of the named colours of things, in pictures and in the scenes of logs."""

from __future__ import annotations

from collections.abc import Mapping

from g3.groundings import Colour

PAINTS: Mapping[Colour, tuple[float, float, float]] = {
    "black": (0.10, 0.10, 0.11),
    "white": (0.98, 0.98, 0.96),
    "grey": (0.52, 0.53, 0.55),
    "red": (0.85, 0.10, 0.09),
    "green": (0.12, 0.58, 0.20),
    "yellow": (1.00, 0.84, 0.08),
    "blue": (0.10, 0.27, 0.80),
    "brown": (0.45, 0.26, 0.12),
    "orange": (1.00, 0.48, 0.05),
    "pink": (1.00, 0.52, 0.68),
    "purple": (0.48, 0.18, 0.62),
}
"""Red, green and blue of each, from 0 to 1."""
