"""Sizes of the robot and of pallets, which physics, pictures and logs share; in metres.

The robot's frame is on the ground between the front wheels, x ahead.
"""

from __future__ import annotations

from typing import TypeAlias

Extent: TypeAlias = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]
"""A box from and to, along x, y and z."""

CHASSIS: Extent = ((-1.2, 0.40), (-0.55, 0.55), (0.12, 2.1))
"""The mast is in front of it, up to the heel of the forks."""
MAST: Extent = ((0.40, 0.48), (-0.35, 0.35), (0.05, 2.1))
HEEL_X = 0.55
"""Position of the forks' heel, where loads touch them."""
FORK_LENGTH = 1.00
FORK_WIDTH = 0.12
FORK_THICKNESS = 0.04
FORK_Y = 0.23
"""The middles of the two tines are this far to the left and the right."""
BACKREST: Extent = ((-0.05, 0.0), (-0.45, 0.45), (-0.04, 0.9))
"""Behind the heel, in the frame of the forks: it goes up and down with them."""
LOW = 0.07
"""Height of the forks' upper side when they are down, above the ground."""
LIFT_RANGE = 2.0

PALLET_HEIGHT = 0.14
"""From the ground to the load on a pallet."""
ENTRY_HEIGHT = 0.11
"""From the ground to the underside of a pallet's deck, where the forks lift."""
BLOCK = 0.12
"""Length of the edges of a pallet's blocks; forks enter between them from all sides."""

CAB_TOP = 2.4
"""Height of a truck's cab above the ground."""
