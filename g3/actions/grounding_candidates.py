"""Candidate groundings of OBJECTs and PLACEs: things, groups of things, and spots around them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice, pairwise

import numpy as np

from g3.actions.arrangements import along_spread, arrangements_of, is_straight
from g3.actions.robot_state import State, centres
from g3.geometry.footprints import centre
from g3.geometry.plane import BoolArray, convex_hull, point_gap, rotate
from g3.geometry.relations import CARRIER_M, LEVEL_M, is_carrier, rests_on
from g3.groundings import Context, FloatArray, Grounding, Path, PhysicalObject, Place, Prism

Group = tuple[Grounding, ...]

MOST_PAIRS = 24
MOST_GAPS = 8
"""Between so many neighbours of a group places are made."""
HALF_M = 1.0
"""Half the side of the places that are made, and their height."""
_CORNERS = HALF_M * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
FREE_M = 1.2
"""Gap between the middle of a place and any thing at its height."""
LOAD_M = 0.6
"""Half the side of most loads."""
DECK_FREE_M = LOAD_M + 0.2
"""Gap on a deck, where loads stand side by side, like `FREE_M`."""
ROW_STEP_M = LOAD_M + DECK_FREE_M + 0.05
"""Between the middles of loads in a row on a deck."""
OVERHANG_M = 0.15
"""A load may stand over the edge of a deck by so much."""
GAP_M = 0.6
"""Between a thing and a place beside it."""
AHEAD_M = (3.0, 6.0)
BESIDE_ROBOT_M = 4.0


@dataclass(frozen=True, slots=True)
class SpotsAsked:
    """Requests for spots that few commands need.

    Parameters
    ----------
    apart
        Distance from the things that they are about, in metres; None for beside them.
    corner
        True for its corners.
    side
        True for the sides of a deck, though it has no room for two loads.
    top
        True for on top of it, though it is no deck but another load.
    """

    apart: float | None = None
    corner: bool = False
    side: bool = False
    top: bool = False


ANY_SPOTS = SpotsAsked()


def object_groups(
    context: Context, held: str | None = None, counts: Collection[int] = ()
) -> tuple[Group, ...]:
    """Return groups that an OBJECT may mean beside single objects: things alike, and places.

    These are all that share a label, with and without what is on the forks, rows and clusters of
    the others, pairs of things alike (the nearest first), and places.

    Parameters
    ----------
    held
        Id of what is on the forks.
    counts
        Sizes of groups that these groups are part of: "the three leftmost crates".
    """
    things = [o for o in context.objects if o.id != context.agent_id]
    groups: dict[tuple[str, ...], tuple[PhysicalObject, ...]] = {}
    for label in sorted({label for o in things for label in o.labels}):
        alike = tuple(o for o in things if label in o.labels)
        for members in (alike, tuple(o for o in alike if o.id != held)):
            groups.setdefault(tuple(o.id for o in members), members)
    arranged = arrangements_of([o for o in things if o.id != held])
    for together in (*arranged.rows, *arranged.clusters):
        groups.setdefault(tuple(o.id for o in together), together)
    for count in counts:
        for whole in [group for group in groups.values() if len(group) > count]:
            for part in _parts(whole, count, context.agent):
                groups.setdefault(tuple(o.id for o in part), part)
    for pair in _pairs(things):
        groups[tuple(o.id for o in pair)] = pair
    several = [group for group in groups.values() if len(group) > 1]
    return (*several, *((place,) for place in context.places))


def _parts(
    things: Sequence[PhysicalObject], count: int, robot: PhysicalObject
) -> list[tuple[PhysicalObject, ...]]:
    """Yield parts of a group: things at either end, the nearest and the farthest."""
    middles = centres([o.prism for o in things])
    away = np.linalg.norm(middles - robot.trajectory.xyz[0, :2], axis=1)
    orders = (along_spread(middles), np.argsort(away, kind="stable"))
    chosen = [part for order in orders for part in (order[:count], order[-count:])]
    return [tuple(things[i] for i in sorted(part.tolist())) for part in chosen]


def _pairs(things: Sequence[PhysicalObject]) -> list[tuple[PhysicalObject, ...]]:
    """Return the nearest pairs of things that share a label."""
    middles = centres([o.prism for o in things])
    first, second = np.triu_indices(len(things), 1)
    distance = np.linalg.norm(middles[first] - middles[second], axis=1)
    pairs: list[tuple[PhysicalObject, ...]] = []
    for i in np.argsort(distance, kind="stable"):
        if len(pairs) == MOST_PAIRS:
            break
        a, b = things[first[i]], things[second[i]]
        if set(a.labels) & set(b.labels):
            pairs.append((a, b))
    return pairs


def spots_about(group: Group, state: State, asked: SpotsAsked = ANY_SPOTS) -> list[Place]:
    """Places on, around and between the things of a group; a place is its own spot.

    Around a thing they lie at the level that it stands on: on a deck, or on the ground.
    """
    spots: list[Place] = []
    for thing in group:
        if isinstance(thing, Place):
            spots.append(grounded(thing, state))
        elif isinstance(thing, PhysicalObject):
            spots += _on(thing, state, asked) + _around(thing, state, asked)
    prisms = [g.prism for g in group if not isinstance(g, Path)]
    return spots if len(prisms) < 2 else spots + _among(prisms, state)


def spots_of_robot(state: State, apart: float | None = None) -> list[Place]:
    """Places ahead of the robot, behind it and at its sides, at a given distance or near by."""
    pose, floor = state.pose, ground(state)
    ahead = [(d, 0.0) for d in ((apart,) if apart else AHEAD_M)]
    aside = apart or BESIDE_ROBOT_M
    beside = [(0.0, aside), (0.0, -aside), (-aside, 0.0)]
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


def spots_of_load(load: str, state: State, apart: float | None = None) -> list[Place]:
    """Places to each side of where a load is, as seen by the robot."""
    sides = rotate(
        np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]), np.full(4, state.pose[2])
    )
    offsets = np.concatenate([d * sides for d in ((apart,) if apart else AHEAD_M)])
    return squares(centre(state.thing(load).prism) + offsets, state.pose[2], ground(state))


def ground(state: State) -> float:
    """Height that the robot stands on."""
    return float(state.context.agent.trajectory.xyz[0, 2])


def grounded(place: Place, state: State) -> Place:
    """Move a place that is near the ground to the ground."""
    floor, prism = ground(state), place.prism
    if not 0 < prism.z_min - floor < LEVEL_M:
        return place
    return Place(Prism(prism.xy, floor, floor + (prism.z_max - prism.z_min)), place.name)


def square(middle: FloatArray, yaw: float, bottom: float) -> Place:
    """Make a place of two metres by two, one metre high."""
    return squares(middle[None], yaw, bottom)[0]


def squares(middles: FloatArray, yaw: float, bottom: float) -> list[Place]:
    """Places of two metres by two, one metre high, around points (n, 2)."""
    footprints = middles[:, None] + rotate(_CORNERS, np.full(len(_CORNERS), yaw))
    return [Place(Prism(xy, bottom, bottom + HALF_M)) for xy in footprints]


def is_surface(thing: PhysicalObject) -> bool:
    """Check that a thing can carry a load: a low one with room, but no heap of earth."""
    if _names_heap(thing.labels):
        return False
    return is_carrier(thing.prism)


@lru_cache(maxsize=4096)
def _names_heap(labels: tuple[str, ...]) -> bool:
    from g3.language.lexicon.tables import WORDS  # noqa: PLC0415 - as in `names_person`

    return not WORDS["heaps"].isdisjoint(word for label in labels for word in label.lower().split())


def _frame(prism: Prism, yaw: float) -> tuple[FloatArray, FloatArray]:
    """Middle of a footprint, and half its length along and across a heading, both (2,)."""
    middle = centre(prism)
    turned = rotate(prism.xy - middle, np.full(len(prism.xy), -yaw))
    return middle, np.abs(turned).max(axis=0)


def _heading(thing: PhysicalObject) -> float:
    return float(thing.trajectory.yaw[0])


def _on(thing: PhysicalObject, state: State, choice: SpotsAsked) -> list[Place]:
    """Places on a deck: in its middle, at its ends and sides, and beside what stands on it."""
    yaw, top = _heading(thing), thing.prism.z_max
    middle, half = _frame(thing.prism, yaw)
    if not is_surface(thing):
        holds = (
            choice.top and half.min() >= LOAD_M - OVERHANG_M and top - thing.prism.z_min < CARRIER_M
        )
        return [square(middle, yaw, top)] if holds else []
    longer = int(half[1] > half[0])
    shift = max(half[longer] - HALF_M - 0.2, 0.0)
    # Loads stand side by side where there is room for two.
    aside = half[1 - longer] / 2 if half[1 - longer] >= 2 * LOAD_M - OVERHANG_M else 0.0
    lanes = (0.0, aside, -aside) if aside else (0.0,)
    offsets = np.array([(x, y) for y in lanes for x in (0.0, shift, -shift)])
    edge = half[1 - longer] - LOAD_M
    if choice.side and not aside and edge > 0:
        offsets = np.concatenate((offsets, [(0.0, edge), (0.0, -edge)]))
    offsets = offsets[:, ::-1] if longer else offsets
    spots = squares(middle + rotate(offsets, np.full(len(offsets), yaw)), yaw, top)
    for load in state.context.objects:
        if rests_on(load.prism, thing.prism):
            spots += [s for s in _around(load, state, ANY_SPOTS) if s.prism.z_min == top]
    return spots


def deck_row(deck: PhysicalObject, state: State) -> list[Place]:
    """Return free places in a row along a deck, as many as it has room for.

    `spots_about` gives its middle and its ends, which leave room for fewer.
    """
    yaw = _heading(deck)
    middle, half = _frame(deck.prism, yaw)
    longer = int(half[1] > half[0])
    reach = float(half[longer]) - LOAD_M + OVERHANG_M
    count = int(2 * reach / ROW_STEP_M) + 1
    offsets = np.zeros((count, 2))
    offsets[:, longer] = (np.arange(count) - (count - 1) / 2) * ROW_STEP_M
    places = squares(middle + rotate(offsets, np.full(count, yaw)), yaw, deck.prism.z_max)
    free = are_free(places, state, None)
    return [place for place, is_free in zip(places, free, strict=True) if is_free]


def _around(thing: PhysicalObject, state: State, choice: SpotsAsked) -> list[Place]:
    """Places on four sides of a thing, along its own axes or those of the deck under it."""
    at = thing.prism.z_min
    deck = carrier(state, thing.id) if at > ground(state) + LEVEL_M else None
    yaw = _heading(deck or thing)
    middle, half = _frame(thing.prism, yaw)
    turns = yaw + np.pi / 2 * np.arange(4)
    ways = np.column_stack((np.cos(turns), np.sin(turns)))
    beside = GAP_M + HALF_M
    gap = np.full(4, beside if choice.apart is None else max(choice.apart + LOAD_M, beside))
    if deck and choice.apart is None:
        # Nearer where the deck ends, if there is still room for a load.
        edges = ((deck.prism.xy - middle) @ ways.T).max(axis=0) - np.tile(half, 2)
        fits = edges >= DECK_FREE_M + LOAD_M - OVERHANG_M
        gap = np.where(fits, np.clip(edges - LOAD_M, DECK_FREE_M, gap), gap)
    points = middle + (np.tile(half, 2) + gap)[:, None] * ways
    if choice.corner:
        # At both ends of each side.
        ends = np.roll(np.tile(half, 2), 1)[:, None] * np.roll(ways, 1, axis=0)
        points = np.concatenate((points, points + ends, points - ends))
    return _squares_at(points, ways[0], at, state)


def _squares_at(points: FloatArray, way: FloatArray, at: float, state: State) -> list[Place]:
    """Places around points (n, 2), on the decks that are there, but none higher than ``at``."""
    floor, yaw = ground(state), float(np.arctan2(way[1], way[0]))
    if at <= floor + LEVEL_M:
        return squares(points, yaw, floor)
    bottom = np.full(len(points), floor)
    for thing in state.context.objects:
        top = thing.prism.z_max
        if thing.id != state.context.agent_id and top < at + LEVEL_M and is_surface(thing):
            inside = point_gap(points[None], convex_hull(thing.prism.xy)[None])[0] <= 0
            bottom = np.where(inside, np.maximum(bottom, top), bottom)
    return [square(p, yaw, float(b)) for p, b in zip(points, bottom, strict=True)]


def _among(prisms: Sequence[Prism], state: State) -> list[Place]:
    """Places between neighbours; of three things and more in their middle, of a row at its ends."""
    middles = centres(prisms)
    order = along_spread(middles)
    spots = []
    for i, j in islice(pairwise(order), MOST_GAPS):
        way = _unit(middles[j] - middles[i])
        far, near = (prisms[i].xy @ way).max(), (prisms[j].xy @ way).min()
        middle = middles[i] + ((far + near) / 2 - middles[i] @ way) * way
        spots += _squares_at(middle[None], way, _lowest([prisms[i], prisms[j]]), state)
    if len(prisms) > 2:
        way, at = _unit(middles[order[-1]] - middles[order[0]]), _lowest(prisms)
        spots += _squares_at(middles.mean(axis=0)[None], way, at, state)
        if is_straight(middles):
            for end, out in ((order[-1], way), (order[0], -way)):
                gap = (prisms[end].xy @ out).max() - middles[end] @ out + GAP_M + HALF_M
                spots += _squares_at((middles[end] + gap * out)[None], way, at, state)
    return spots


def _unit(way: FloatArray) -> FloatArray:
    return way / max(float(np.linalg.norm(way)), 1e-9)


def _lowest(prisms: Sequence[Prism]) -> float:
    return min(prism.z_min for prism in prisms)


def standing(places: Sequence[Place], state: State) -> BoolArray:
    """Return the things that stand in the middle of n places, or too near to put a load down.

    Returns
    -------
    BoolArray
        For each place and each of the context's objects, shape (n, m). What the place is on, and
        the robot, aren't in the way.
    """
    middles = centres([place.prism for place in places])
    bottoms = np.array([place.prism.z_min for place in places])
    room = np.where(bottoms > ground(state) + LEVEL_M, DECK_FREE_M, FREE_M)
    taken = np.zeros((len(places), len(state.context.objects)), dtype=bool)
    for column, thing in enumerate(state.context.objects):
        xy = thing.prism.xy
        near = ((middles >= xy.min(axis=0) - FREE_M) & (middles <= xy.max(axis=0) + FREE_M)).all(
            axis=1
        )
        near &= thing.prism.z_max > bottoms + 0.3
        if thing.id != state.context.agent_id and near.any():
            gaps = point_gap(middles[None, near], convex_hull(xy)[None])[0]
            taken[near, column] = gaps <= room[near]
    return taken


def are_free(places: Sequence[Place], state: State, load: str | None) -> BoolArray:
    """Check that nothing else stands in places (n,), so that a load can be put down; shape (n,)."""
    return free_of(standing(places, state), state, load)


def free_of(taken: BoolArray, state: State, load: str | None) -> BoolArray:
    """Check the result of :func:`standing` for free places."""
    others = np.array([o.id != load for o in state.context.objects], dtype=bool)
    return np.asarray(~(taken & others).any(axis=1))


def footprint_of(group: Sequence[Grounding]) -> FloatArray:
    """Return the hull of a group's footprints, shape (k, 2)."""
    corners = [g.prism.xy for g in group if not isinstance(g, Path)]
    return convex_hull(corners[0] if len(corners) == 1 else np.concatenate(corners))


def beneath(place: Place, state: State, load: str | None) -> PhysicalObject | None:
    """Return the thing under a place; None for the ground."""
    return next(
        (
            o
            for o in state.context.objects
            if o.id not in (load, state.context.agent_id) and rests_on(place.prism, o.prism)
        ),
        None,
    )


def carrier(state: State, object_id: str) -> PhysicalObject | None:
    """Return the thing under an object; None for the ground."""
    return beneath(Place(state.thing(object_id).prism), state, object_id)
