"""Candidate groundings of OBJECTs and PLACEs: things, groups of things, and spots around them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations

import numpy as np
from scipy.sparse.csgraph import connected_components

from g3.actions.facing import ROW
from g3.actions.robot_state import State, centres
from g3.geometry.footprints import centre, covers
from g3.geometry.plane import BoolArray, area, convex_hull, point_gap, rotate
from g3.groundings import Context, FloatArray, Grounding, Path, PhysicalObject, Place, Prism

Group = tuple[Grounding, ...]

MOST_PAIRS = 24
ROW_GAP_M = 5.0
"""Things in a row are no further apart."""
PAIR_M = 12.0
"""Things further apart than this are no pair that one would speak of."""
HALF_M = 1.0
"""Half the side of the places that are made, and their height."""
_CORNERS = HALF_M * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
SURFACE_M2 = 4.0
"""Things at least this large can have a load put on top."""
FREE_M = 1.2
"""Gap between the middle of a place and whatever stands at its height."""
GAP_M = 0.6
"""Between a thing and a place beside it."""
AHEAD_M = (3.0, 6.0)
BESIDE_ROBOT_M = 4.0
GROUND_M = 0.35
"""Places with their bottom no higher than this over the ground are on it."""


def object_groups(context: Context, held: str | None = None) -> tuple[Group, ...]:
    """What an OBJECT may be besides a single object: groups of things alike, and places.

    All things with the same labels, all that share a label, rows without what is on the forks,
    pairs of things alike that are near each other (the nearest first), and the context's places.
    """
    things = [o for o in context.objects if o.id != context.agent_id]
    groups: dict[tuple[str, ...], tuple[PhysicalObject, ...]] = {}
    for label in sorted({label for o in things for label in o.labels}):
        alike = tuple(o for o in things if label in o.labels)
        groups[tuple(o.id for o in alike)] = alike
    for row in rows_of([o for o in things if o.id != held]):
        groups[tuple(o.id for o in row)] = row
    for pair in _pairs(things):
        groups[tuple(o.id for o in pair)] = pair
    several = [group for group in groups.values() if len(group) > 1]
    return (*several, *((place,) for place in context.places))


def rows_of(things: Sequence[PhysicalObject]) -> list[tuple[PhysicalObject, ...]]:
    """Three things and more that share a label and stand near one another: a row of pallets."""
    middles = centres([o.prism for o in things])
    bottom = np.array([o.prism.z_min for o in things])
    near = np.linalg.norm(middles[:, None] - middles[None], axis=-1) < ROW_GAP_M
    near &= np.abs(bottom[:, None] - bottom) < GROUND_M
    names = sorted({label for o in things for label in o.labels})
    has = np.array([[name in o.labels for name in names] for o in things], dtype=bool)
    near &= has @ has.T
    count, of = connected_components(near, directed=False)
    found = [tuple(o for o, c in zip(things, of, strict=True) if c == i) for i in range(count)]
    return [row for row in found if len(row) >= ROW]


def _pairs(things: Sequence[PhysicalObject]) -> list[tuple[PhysicalObject, ...]]:
    """The nearest pairs of things that share a label."""
    middles = centres([o.prism for o in things])
    first, second = np.triu_indices(len(things), 1)
    distance = np.linalg.norm(middles[first] - middles[second], axis=1)
    found: list[tuple[PhysicalObject, ...]] = []
    for i in np.argsort(distance, kind="stable"):
        if len(found) == MOST_PAIRS or distance[i] > PAIR_M:
            break
        a, b = things[first[i]], things[second[i]]
        if set(a.labels) & set(b.labels):
            found.append((a, b))
    return found


def spots_about(group: Group, state: State) -> list[Place]:
    """Places on, around and between the things of a group; a place is its own spot."""
    spots: list[Place] = []
    for thing in group:
        if isinstance(thing, Place):
            spots.append(grounded(thing, state))
        elif isinstance(thing, PhysicalObject):
            spots += _on(thing) + _around(thing, state)
    if len(group) == 2:
        spots += _between(group, state)
    elif len(group) > 2:
        spots += [s for pair in combinations(group[:4], 2) for s in _between(pair, state)]
    return spots


def spots_of_robot(state: State) -> list[Place]:
    """Places ahead of the robot, behind it and beside it, as far as a load's reach goes on."""
    pose, floor = state.pose, ground(state)
    ahead = [(d, 0.0) for d in AHEAD_M]
    beside = [(0.0, BESIDE_ROBOT_M), (0.0, -BESIDE_ROBOT_M), (-BESIDE_ROBOT_M, 0.0)]
    offsets = rotate(np.array(ahead + beside), np.full(len(ahead) + len(beside), pose[2]))
    return squares(pose[:2] + offsets, pose[2], floor)


def spots_toward(group: Group, state: State, load: str | None) -> list[Place]:
    """Places on the way from where a load is, or the robot without one, to things."""
    start = centre(state.thing(load).prism) if load else state.pose[:2]
    prisms = [g.prism for g in group if isinstance(g, (PhysicalObject, Place))]
    way = centres(prisms).mean(axis=0) - start
    away = float(np.linalg.norm(way))
    steps = [start + d / away * way for d in AHEAD_M if d < away]
    yaw = float(np.arctan2(way[1], way[0]))
    return squares(np.array(steps).reshape(-1, 2), yaw, ground(state))


def spots_of_load(load: str, state: State) -> list[Place]:
    """Places to each side of where a load is, as seen by the robot."""
    sides = rotate(
        np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]), np.full(4, state.pose[2])
    )
    offsets = np.concatenate([distance * sides for distance in AHEAD_M])
    return squares(centre(state.thing(load).prism) + offsets, state.pose[2], ground(state))


def ground(state: State) -> float:
    """Height that the robot stands on."""
    return float(state.context.agent.trajectory.xyz[0, 2])


def grounded(place: Place, state: State) -> Place:
    """A place with its bottom on the ground if it is near."""
    floor, prism = ground(state), place.prism
    if not 0 < prism.z_min - floor < GROUND_M:
        return place
    return Place(Prism(prism.xy, floor, floor + prism.z_max - prism.z_min), place.name)


def square(middle: FloatArray, yaw: float, bottom: float) -> Place:
    """A place of two metres by two, one metre high."""
    return squares(middle[None], yaw, bottom)[0]


def squares(middles: FloatArray, yaw: float, bottom: float) -> list[Place]:
    """Places of two metres by two, one metre high, around points (n, 2)."""
    footprints = middles[:, None] + rotate(_CORNERS, np.full(len(_CORNERS), yaw))
    return [Place(Prism(xy, bottom, bottom + HALF_M)) for xy in footprints]


def is_surface(thing: PhysicalObject) -> bool:
    """Whether a load can be put on top of a thing."""
    low = thing.prism.z_max - thing.prism.z_min
    return bool(area(convex_hull(thing.prism.xy)[None])[0] >= SURFACE_M2) and low < 1.5


def _frame(thing: PhysicalObject) -> tuple[FloatArray, float, float, float]:
    """Middle, heading, and half the length along and across it of a thing's footprint."""
    yaw = float(thing.trajectory.yaw[0])
    middle = centre(thing.prism)
    own = rotate(thing.prism.xy - middle, np.full(len(thing.prism.xy), -yaw))
    along, across = np.abs(own).max(axis=0)
    return middle, yaw, float(along), float(across)


def _on(thing: PhysicalObject) -> list[Place]:
    if not is_surface(thing):
        return []
    middle, yaw, along, across = _frame(thing)
    axis = np.array([np.cos(yaw), np.sin(yaw)])
    if across > along:
        axis, along = np.array([-axis[1], axis[0]]), across
    shift = max(along - HALF_M - 0.2, 0.0)
    top = thing.prism.z_max
    return squares(middle + np.outer((0.0, shift, -shift), axis), yaw, top)


def _around(thing: PhysicalObject, state: State) -> list[Place]:
    middle, yaw, along, across = _frame(thing)
    away = np.array([along, across, along, across]) + GAP_M + HALF_M
    turns = yaw + np.pi / 2 * np.arange(4)
    ways = np.column_stack((np.cos(turns), np.sin(turns)))
    bottom = ground(state) if thing.prism.z_min < 1.0 else thing.prism.z_min
    return squares(middle + away[:, None] * ways, yaw, bottom)


def _between(pair: Iterable[Grounding], state: State) -> list[Place]:
    a, b = (
        centre(g.prism) for g in pair if not isinstance(g, (type(None),)) and hasattr(g, "prism")
    )
    yaw = float(np.arctan2(*(b - a)[::-1]))
    return [square((a + b) / 2, yaw, ground(state))]


def standing(places: Sequence[Place], state: State) -> BoolArray:
    """What stands in the middle of places, or too near to put something down there.

    Parameters
    ----------
    places
        n places.

    Returns
    -------
    BoolArray
        For each place and each of the context's objects, shape (n, m). What the place is on, and
        the robot, aren't in the way.
    """
    middles = centres([place.prism for place in places])
    bottoms = np.array([place.prism.z_min for place in places])
    taken = np.zeros((len(places), len(state.context.objects)), dtype=bool)
    for column, thing in enumerate(state.context.objects):
        xy = thing.prism.xy
        near = ((middles >= xy.min(axis=0) - FREE_M) & (middles <= xy.max(axis=0) + FREE_M)).all(
            axis=1
        )
        near &= thing.prism.z_max > bottoms + 0.3
        if thing.id != state.context.agent_id and near.any():
            gaps = point_gap(middles[None, near], convex_hull(xy)[None])[0]
            taken[near, column] = gaps <= FREE_M
    return taken


def are_free(places: Sequence[Place], state: State, load: str | None) -> BoolArray:
    """Whether a load can be put down in places (n,): nothing else stands there; shape (n,)."""
    return free_of(standing(places, state), state, load)


def free_of(taken: BoolArray, state: State, load: str | None) -> BoolArray:
    """The same for what :func:`standing` gives."""
    others = np.array([o.id != load for o in state.context.objects], dtype=bool)
    return np.asarray(~(taken & others).any(axis=1))


def footprint_of(group: Sequence[Grounding]) -> FloatArray:
    """The hull of a group's footprints, shape (k, 2)."""
    corners = [g.prism.xy for g in group if not isinstance(g, Path)]
    return convex_hull(corners[0] if len(corners) == 1 else np.concatenate(corners))


def beneath(place: Place, state: State, load: str | None) -> PhysicalObject | None:
    """What a place is on; None for the ground."""
    middle = centre(place.prism)
    return next(
        (
            o
            for o in state.context.objects
            if o.id not in (load, state.context.agent_id)
            and abs(o.prism.z_max - place.prism.z_min) < GROUND_M
            and covers(o.prism, middle)
        ),
        None,
    )


def carrier(state: State, object_id: str) -> PhysicalObject | None:
    """What an object stands on; None for the ground."""
    return beneath(Place(state.thing(object_id).prism), state, object_id)
