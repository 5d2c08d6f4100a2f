"""Where in a place something can stand."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from corpus_tools.world.physics.controller import ActionError, Simulation
from corpus_tools.world.state.recording import heading
from corpus_tools.world.state.solids import deck_of
from corpus_tools.world.state.thing_kinds import kind_of
from g3.geometry.footprints import centre
from g3.geometry.plane import convex_hull, cross, rotate
from g3.groundings import FloatArray, Place
from g3.short_repr import short_repr

NUDGE_M = 0.1
"""What stands this far from the middle of a place is still where it was asked for."""
FIRM_M = 0.3
"""How far from the edge of a deck the middle of a load is at least."""
IN_THE_AIR_M = 0.4
"""A place this far above what is under it is in the air."""
_GRID_M = 0.1
_TOUCH_M = 0.03


def axis_of(place: Place) -> float:
    """The heading of a place's longest edge."""
    corners = convex_hull(place.prism.xy)
    edges = np.roll(corners, -1, axis=0) - corners
    x, y = edges[np.argmax(np.hypot(*edges.T))]
    return float(np.arctan2(y, x))


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Support:
    """What a load put down in a place stands on."""

    height: float
    """Above the ground."""
    axis: float
    """Heading that the load is to be parallel to."""
    carrier: str | None = None
    """The object, None for the ground."""
    deck: FloatArray | None = None
    """Corners (4, 2) of where the object can be loaded, counterclockwise; None on the ground."""

    def holds(self, middle: FloatArray) -> bool:
        """Whether what has its middle (2,) there can't fall off."""
        if self.deck is None:
            return True
        edges = np.roll(self.deck, -1, axis=0) - self.deck
        inwards = cross(edges, middle - self.deck) / np.hypot(*edges.T)
        return bool((inwards >= FIRM_M).all())


def support_at(sim: Simulation, place: Place) -> Support:
    """What a load put down in a place's middle stands on; ActionError if that is in the air."""
    low = place.prism.z_min - sim.ground_m
    found = Support(0.0, axis_of(place))
    for item in sim.start.objects:
        kind = kind_of(item.labels)
        if kind.deck is None:
            continue
        shape = sim.shape(item.id)
        xyz, orientation = sim.body_pose(item.id)
        yaw = float(heading(orientation))
        begin, end = deck_of(kind, shape)
        right, left = float(shape.low[1]), float(shape.high[1])
        corners = np.array([[begin, right], [end, right], [end, left], [begin, left]])
        deck = xyz[:2] + rotate(corners, np.full(4, yaw))
        height = float(xyz[2] + shape.high[2] - sim.ground_m)
        x, y = rotate(centre(place.prism) - xyz[:2], np.array(-yaw))
        # Over the cab, too: what is wanted up there goes onto the deck.
        over = shape.low[0] <= x <= shape.high[0] and right <= y <= left
        if over and abs(height - low) < abs(found.height - low):
            found = Support(height, yaw, item.id, deck)
    if low - found.height > IN_THE_AIR_M:
        raise ActionError(
            f"nothing that can be loaded is under {place.name or 'the place'}, {low:.1f} m up"
        )
    return found


def carrier_under(sim: Simulation, thing: str) -> str | None:
    """The object that an object stands on, None if that is the ground."""
    shape, (xyz, orientation) = sim.shape(thing), sim.body_pose(thing)
    middle = xyz[:2] + rotate(shape.middle[:2], heading(orientation))
    for item in sim.start.objects:
        if item.id in (thing, sim.start.agent_id):
            continue
        other, (at, turned) = sim.shape(item.id), sim.body_pose(item.id)
        local = rotate(middle - at[:2], -heading(turned))
        over = (other.low[:2] <= local).all() and (local <= other.high[:2]).all()
        if over and abs(at[2] + other.high[2] - xyz[2] - shape.low[2]) < _TOUCH_M:
            return item.id
    return None


def spots(place: Place, footprint: FloatArray, reach_m: float = 3.0) -> Iterator[FloatArray]:
    """Offsets (2,) from a place's middle at which a footprint is in the place, nearest first.

    The middle comes first whether it is or not, then what is a nudge away. `footprint` has the
    corners relative to what stands in the middle, shape (k, 2).
    """
    corners = convex_hull(place.prism.xy) - centre(place.prism)
    edges = np.roll(corners, -1, axis=0) - corners
    steps = np.arange(-round(reach_m / _GRID_M), round(reach_m / _GRID_M) + 1) * _GRID_M
    grid = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
    axis = axis_of(place)
    grid = rotate(grid, np.full(len(grid), axis))
    far = np.hypot(*grid.T)
    at = grid[:, None, None] + footprint[None, :, None] - corners
    inside = (cross(edges, at) >= -0.02).all(axis=(1, 2))
    chosen = np.flatnonzero(inside | (far <= NUDGE_M + 1e-9))
    for i in chosen[np.argsort(far[chosen], kind="stable")]:
        yield grid[i]
