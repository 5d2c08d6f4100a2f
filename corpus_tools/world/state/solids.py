"""Collision geometry and masses of objects."""

from __future__ import annotations

from typing import TYPE_CHECKING

from corpus_tools.world.state.dimensions import BLOCK, CAB_TOP, ENTRY_HEIGHT, PALLET_HEIGHT, Extent
from corpus_tools.world.state.shapes import Shape
from corpus_tools.world.state.thing_kinds import Kind

if TYPE_CHECKING:
    import mujoco

SOLID_GROUP = 3
"""Group of geoms that collide and aren't seen."""

PALLET_KG, LOAD_KG = 25.0, 275.0

FRICTION = 0.8

CAB_OVER_DECK_M = 0.8
"""Least height of a truck's cab above its deck, in metres, as it is in pictures."""


def add_solid(body: mujoco.MjsBody, kind: Kind, shape: Shape, ground_m: float = 0.0) -> None:
    """Add the geoms that an object collides with; `ground_m` is the ground in its frame."""
    if kind.carriable:
        _add_pallet(body, shape)
        (x0, y0, z0), (x1, y1, z1) = shape.low.tolist(), shape.high.tolist()
        box(body, ((x0, x1), (y0, y1), (z0 + PALLET_HEIGHT, z1)), mass=LOAD_KG)
        return
    for extent in extents(kind, shape, ground_m):
        box(body, extent)


def extents(kind: Kind, shape: Shape, ground_m: float) -> list[Extent]:
    """Return the boxes that an object fills; `ground_m` is the ground in its frame."""
    x, y, z = zip(shape.low.tolist(), shape.high.tolist(), strict=True)
    if kind.deck is None:
        return [(x, y, z)]
    # Nothing drives under a deck: wheels and frame are in the way.
    cab_z = (z[1], ground_m + cab_top(z[1] - ground_m))
    return [(x, y, (ground_m, z[1])), *((cab, y, cab_z) for cab in beside_deck(kind, shape))]


def cab_top(deck_m: float) -> float:
    """Return the height of a truck's cab above the ground: over its deck, at any deck height."""
    return max(CAB_TOP, deck_m + CAB_OVER_DECK_M)


def deck_of(kind: Kind, shape: Shape) -> tuple[float, float]:
    """Return the part of an object's top that can be loaded, from and to along x."""
    if kind.deck is None:
        raise ValueError(f"a {kind.name} has no deck")
    scale = shape.size[0] / kind.size[0]
    low, high = (float(shape.middle[0] + x * scale) for x in kind.deck)
    return low, high


def beside_deck(kind: Kind, shape: Shape) -> tuple[tuple[float, float], ...]:
    """Return the parts along x of an object's top that aren't its deck: a truck's cab."""
    low, high = deck_of(kind, shape)
    rest = ((float(shape.low[0]), low), (high, float(shape.high[0])))
    return tuple(part for part in rest if part[1] - part[0] > 0.01)


def box(body: mujoco.MjsBody, extent: Extent, mass: float = 0.0) -> None:
    """Add a box that collides."""
    import mujoco  # noqa: PLC0415 - who only asks where things are does without

    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[(low + high) / 2 for low, high in extent],
        size=[(high - low) / 2 for low, high in extent],
        mass=mass,
        friction=[FRICTION, 0.005, 0.0001],
        group=SOLID_GROUP,
    )


def _add_pallet(body: mujoco.MjsBody, shape: Shape) -> None:
    """Add a deck on nine blocks."""
    (x0, y0, z0), (x1, y1, _) = shape.low.tolist(), shape.high.tolist()
    deck = ((x0, x1), (y0, y1), (z0 + ENTRY_HEIGHT, z0 + PALLET_HEIGHT))
    box(body, deck, mass=PALLET_KG)
    for x in _thirds(x0, x1):
        for y in _thirds(y0, y1):
            box(body, (x, y, (z0, z0 + ENTRY_HEIGHT)))


def _thirds(low: float, high: float) -> tuple[tuple[float, float], ...]:
    middle = (low + high) / 2
    starts = (low, middle - BLOCK / 2, high - BLOCK)
    return tuple((start, start + BLOCK) for start in starts)
