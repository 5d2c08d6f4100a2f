"""Layout of objects relative to each other and to an onlooker: left, ahead, nearest."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations

import numpy as np

from eval.judging.grounded_command import GroundedCommand, Things
from eval.judging.modifiers import Modifier
from g3.actions.grounding_candidates import carrier
from g3.geometry.footprints import centre
from g3.geometry.plane import convex_hull, gap, rotate
from g3.groundings import FloatArray, Prism
from g3.language.lexicon.concepts import Concept

BESIDE_M = 4.0
"""Largest distance from a thing's border that is next to it, in metres."""
NEAR_M = 6.0
"""Largest distance from a thing's border that is near, before or behind it, in metres."""
ASIDE_M = 3.0
"""Largest distance from the line between two middles that is between them, in metres."""
AHEAD = np.pi / 3
"""Largest angle off the direction of view that is ahead, in radians."""
ASIDE = np.pi / 12
"""Smallest angle off the direction of view that is to the left or the right, in radians."""


def nearest(one: Prism, others: Iterable[Prism]) -> float:
    """Return the distance in metres to the nearest footprint of several; infinite without one."""
    own = convex_hull(one.xy)[None]
    return min((float(gap(own, convex_hull(o.xy)[None])[0]) for o in others), default=np.inf)


def seen(pose: FloatArray, points: FloatArray) -> FloatArray:
    """Return points (n, 2) in the frame of a pose x, y, yaw: distances ahead and to the left."""
    return rotate(points - pose[:2], np.full(len(points), -pose[2]))


def looking_at(pose: FloatArray, points: FloatArray) -> FloatArray:
    """Return the pose turned towards the middle of points, shape (n, 2)."""
    way = points.mean(axis=0) - pose[:2]
    return np.array([*pose[:2], np.arctan2(way[1], way[0])])


def is_between(one: Prism, others: Sequence[Prism]) -> bool:
    """Check that an object lies between any two of several."""
    point = centre(one)
    return any(_between(point, centre(a), centre(b)) for a, b in combinations(others, 2))


def _between(point: FloatArray, a: FloatArray, b: FloatArray) -> bool:
    way = b - a
    length = float(np.linalg.norm(way))
    if length < 1e-6:
        return False
    along, aside = seen(np.array([*a, np.arctan2(way[1], way[0])]), point[None])[0]
    return bool(0 < along < length and abs(aside) <= ASIDE_M)


def prisms(words: GroundedCommand, ids: Things) -> list[Prism]:
    """Return the shapes of objects at the start."""
    return [words.state.thing(i).prism for i in sorted(ids)]


def of_kind(words: GroundedCommand, ids: Things) -> Things:
    """Things that share a label with some of those given, and these."""
    known = {label for i in ids for label in words.state.thing(i).labels}
    things = words.state.context.objects
    return frozenset(o.id for o in things if o.id != words.robot and known & set(o.labels))


def in_order(words: GroundedCommand, modifier: Modifier, found: Things, group: Things) -> Things:
    """Select things on a side, or by their number from it: of all, on a thing, or in a row.

    `found` are the candidates. `group` is the thing that they are on or beside, or their row; it is
    empty for all candidates.
    """
    side, number = modifier.side, modifier.ordinal
    on = {i for i in found if (under := carrier(words.state, i)) and under.id in group}
    among = frozenset(on) or (group & found) or found
    if group and among == found and not (on or group & found):
        return _beside_group(words, found, group, side)
    sets = _together(words, among)
    if number and not group:
        # "The third pallet" may count pallets of other kinds in the row, too.
        sets += _together(words, of_kind(words, among))
    fitting = {i for ids in sets for i in _placed(_from_left(words, ids), side, number)}
    if side and not number and not group:
        fitting |= {i for i in found if _is_aside(words, i, side)}
    return found & fitting


def inner(words: GroundedCommand, found: Things) -> Things:
    """Those of a row that aren't at its ends."""
    rows = _together(words, of_kind(words, found))
    return found & frozenset(i for ids in rows for i in _from_left(words, ids)[1:-1])


def straight_ahead(words: GroundedCommand, found: Things, way: int = 1) -> Things:
    """Return the nearest and straightest object ahead or behind, or the held one."""
    ids = sorted(found)
    if not ids:
        return found
    place = way * seen(words.state.pose, _middles(words, ids))
    off = np.abs(np.arctan2(place[:, 1], place[:, 0]))
    away = np.where(off <= AHEAD, np.linalg.norm(place, axis=1), np.inf)
    best = {ids[k] for k in (int(np.argmin(off)), int(np.argmin(away))) if off[k] <= AHEAD}
    return frozenset(best) | (found & {words.state.held or ""})


def by_distance(words: GroundedCommand, found: Things, *, far: bool) -> Things:
    """Return the object nearest to the robot, or the farthest."""
    ids = sorted(found)
    if not ids:
        return found
    away = np.linalg.norm(_middles(words, ids) - words.state.pose[:2], axis=1)
    return frozenset({ids[int(np.argmax(away) if far else np.argmin(away))]})


def _placed(order: list[str], side: Concept | None, number: int | None) -> list[str]:
    """Select things by their place from a side, from either if none is given; else half of them."""
    count = len(order)
    found = []
    for left, i in enumerate(order, start=1):
        right = count + 1 - left
        places = {"left": (left,), "right": (right,)}.get(side or "", (left, right))
        if number in places or (not number and (count == 1 or 2 * places[0] < count + 1)):
            found.append(i)
    return found


def _together(words: GroundedCommand, ids: Things) -> list[Things]:
    """Those that stand on the same thing, or on the ground; all if each stands on another."""
    by: dict[str, set[str]] = {}
    for i in ids:
        under = carrier(words.state, i)
        by.setdefault(under.id if under else "", set()).add(i)
    return [frozenset(own) for own in by.values() if len(own) > 1] or [ids]


def _from_left(words: GroundedCommand, ids: Things) -> list[str]:
    order = sorted(ids)
    if not order:
        return []
    points = _middles(words, order)
    leftward = seen(looking_at(words.state.pose, points), points)[:, 1]
    return [order[i] for i in np.argsort(-leftward, kind="stable")]


def _middles(words: GroundedCommand, ids: list[str]) -> FloatArray:
    return np.array([centre(words.state.thing(i).prism) for i in ids])


def _is_aside(words: GroundedCommand, thing: str, side: Concept) -> bool:
    [[ahead, left]] = seen(words.state.pose, _middles(words, [thing]))
    angle = float(np.arctan2(left, ahead))
    return (angle if side == "left" else -angle) >= ASIDE


def _beside_group(
    words: GroundedCommand, found: Things, group: Things, side: Concept | None
) -> Things:
    """Those near a group, on its side as an onlooker sees it."""
    if side is None:
        return frozenset()
    around = prisms(words, group)
    points = _middles(words, sorted(group))
    view = looking_at(words.state.pose, points)
    middle = float(seen(view, points)[:, 1].mean())
    sign = 1 if side == "left" else -1
    return frozenset(
        i
        for i in found
        if nearest(words.state.thing(i).prism, around) <= NEAR_M
        and sign * (float(seen(view, _middles(words, [i]))[0, 1]) - middle) > 0
    )
