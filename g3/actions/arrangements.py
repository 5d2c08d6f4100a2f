"""Arrangements of things that stand together: rows and clusters, by their own spacing.

Nothing here knows a length: a row of parked trucks and one of crates are rows alike.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from g3.actions.robot_state import centres
from g3.geometry.plane import BoolArray, IntArray, cross, length
from g3.geometry.relations import LEVEL_M
from g3.groundings import FloatArray, PhysicalObject
from g3.short_repr import short_repr

ROW, NARROW, BEFORE = 3, 0.4, 0.25
"""Least things in a row; largest spread across it, as a share of along it; least distance of a
speaker from its line, as a share of the distance beyond its end."""
ONE_SIDE = 0.2
"""Things lie on one side if no direction to them has a smaller cosine to the middle one."""


def facing(own: FloatArray, others: FloatArray, rival: BoolArray) -> tuple[FloatArray, BoolArray]:
    """Return the directions in which things are described: unit vectors, robot's frame (n, 2).

    At a row straight on; else to the middle of things that lie on one side, or ahead if they are
    all around. The second array is True for the latter, shape (n,).

    Parameters
    ----------
    own
        Centres of the figures in the robot's frame, shape (n, 2).
    others, rival
        Centres of their peers (n, p, 2), and which of these are looked at too, shape (n, p).
    """
    points = np.concatenate((own[:, None], others), axis=1)
    seen = np.column_stack((np.ones(len(own), dtype=bool), rival))
    unit = points / np.maximum(np.linalg.norm(points, axis=-1, keepdims=True), 1e-9)
    mean = np.where(seen[..., None], unit, 0.0).sum(axis=1)
    length = np.linalg.norm(mean, axis=1, keepdims=True)
    mean = mean / np.maximum(length, 1e-9)
    cosine = np.where(seen, (unit * mean[:, None]).sum(axis=-1), 1.0).min(axis=1)
    aside = (cosine >= ONE_SIDE) & (length[:, 0] > 1e-6)
    across, straight = rows(points, seen)
    chosen = np.where(aside[:, None], mean, np.array([1.0, 0.0]))
    return np.where(straight[:, None], across, chosen), ~(straight | aside)


def lines(points: FloatArray, seen: BoolArray) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Fit lines along which points spread most.

    Parameters
    ----------
    points, seen
        Shape (n, p, 2), and which of them count, shape (n, p).

    Returns
    -------
    middle, axes : FloatArray
        The points' middles (n, 2), and unit vectors across and along the lines in the columns of
        (n, 2, 2).
    straight : BoolArray
        True where the points are a row, shape (n,).
    """
    weight = seen / seen.sum(axis=1)[:, None]
    middle = (points * weight[..., None]).sum(axis=1)
    offset = (points - middle[:, None]) * np.sqrt(weight)[..., None]
    spread, axes = np.linalg.eigh(np.swapaxes(offset, 1, 2) @ offset)
    return middle, axes, (seen.sum(axis=1) >= ROW) & (spread[:, 0] < NARROW**2 * spread[:, 1])


def rows(points: FloatArray, seen: BoolArray) -> tuple[FloatArray, BoolArray]:
    """Return unit vectors from the robot straight at rows (n, 2), and which points are rows.

    A row that the robot is in, or that it looks along, isn't faced.

    Parameters
    ----------
    points, seen
        In the robot's frame, shape (n, p, 2), and which of them are looked at, shape (n, p).
    """
    middle, axes, straight = lines(points, seen)
    across = axes[..., 0]
    offset = np.where(seen[..., None], points - middle[:, None], 0.0)
    thick, reach = np.abs(offset @ axes).max(axis=1).T
    away, along = (middle[:, None] @ axes)[:, 0].T
    beyond = np.maximum(np.abs(along) - reach, 0.0)
    straight &= np.abs(away) > np.maximum(thick, BEFORE * beyond)
    return across * np.where(away < 0, -1.0, 1.0)[:, None], straight


def turned(points: FloatArray, ahead: FloatArray) -> FloatArray:
    """Points (..., 2) in the frame of who looks along unit vectors (..., 2)."""
    forward = (points * ahead).sum(axis=-1)
    leftward = points[..., 1] * ahead[..., 0] - points[..., 0] * ahead[..., 1]
    return np.stack((forward, leftward), axis=-1)


UNEVEN = 1.75
"""In a row a gap is at most so many times the one before it."""
BENT = np.sin(np.radians(25))
"""From one thing to the next a row turns by no more."""
APART = 1.25
"""A row's spacing is at most so many times the gap to things alike that aren't of it."""
ISOLATED = 1.5
"""A cluster is so many times as far from the next thing alike as its own things are."""
NEAREST = 8
"""Neighbours of each thing from which rows are begun."""

Things = tuple[PhysicalObject, ...]


@short_repr
@dataclass(frozen=True, slots=True)
class Arrangements:
    """Things that stand together.

    Parameters
    ----------
    rows
        Straight rows of three things and more that share a label, but no parts of other rows.
    clusters
        Three things and more that share a label and are nearer to each other than to the rest.
    """

    rows: tuple[Things, ...]
    clusters: tuple[Things, ...]


def arrangements_of(things: Sequence[PhysicalObject]) -> Arrangements:
    """Return the rows and the clusters of things, in the order of their first things."""
    rows: set[frozenset[int]] = set()
    clusters: set[frozenset[int]] = set()
    for alike, middles in _alike(things):
        straight, isolated = _found(middles.tobytes())
        rows |= {frozenset(alike[run].tolist()) for run in straight}
        clusters |= {frozenset(alike[members].tolist()) for members in isolated}
    whole = (run for run in rows if not any(run < other for other in rows))
    return Arrangements(
        *(
            tuple(tuple(things[i] for i in members) for members in sorted(map(sorted, groups)))
            for groups in (whole, clusters)
        )
    )


def _alike(things: Sequence[PhysicalObject]) -> Iterable[tuple[IntArray, FloatArray]]:
    """Yield indices and middles of things that share a label and a level, if they may be a row."""
    middles = centres([thing.prism for thing in things])
    bottom = np.array([thing.prism.z_min for thing in things])
    order = np.argsort(bottom, kind="stable")
    level = np.empty(len(things), dtype=np.intp)
    level[order] = np.cumsum(np.diff(bottom[order], prepend=bottom[order[:1]]) > LEVEL_M)
    seen: set[bytes] = set()
    for label in sorted({label for thing in things for label in thing.labels}):
        has = np.array([label in thing.labels for thing in things], dtype=bool)
        for height in range(level.max(initial=-1) + 1):
            on_level = np.flatnonzero(has & (level == height))
            if len(on_level) >= ROW and on_level.tobytes() not in seen:
                seen.add(on_level.tobytes())
                yield on_level, middles[on_level]


# The same world is asked for command after command.
@lru_cache(maxsize=1 << 10)
def _found(middles: bytes) -> tuple[list[list[int]], list[list[int]]]:
    """Straight rows and clusters of points (n, 2)."""
    points = np.frombuffer(middles).reshape(-1, 2)
    return _straight(points), _isolated(points)


def _straight(middles: FloatArray) -> list[list[int]]:
    """Straight rows of points (n, 2): each goes on from a pair of neighbours as far as it can."""
    gap = length(middles[:, None] - middles)
    np.fill_diagonal(gap, np.inf)
    near = np.argsort(gap, axis=1, kind="stable")[:, : min(NEAREST, len(middles) - 1)]
    first, second = np.repeat(np.arange(len(middles)), near.shape[1]), near.reshape(-1)
    step, size = middles[second] - middles[first], gap[first, second]
    # What is beyond the nearest things of one is neither next in its row nor nearer than that.
    from_first, _ = _relative(middles, first, near[first], step)
    from_second, ahead = _relative(middles, second, near[second], step)
    # Nothing off the line is much nearer to a row's things than they are to each other.
    off_line = np.maximum(from_first.min(axis=1), from_second.min(axis=1))
    on = gap[second[:, None], near[second]]
    even = (on <= UNEVEN * size[:, None]) & (size[:, None] <= UNEVEN * on)
    reach = np.where(ahead & even & (size <= APART * off_line)[:, None], on, np.inf)
    chosen = near[second, reach.argmin(axis=1)]
    follower = np.where(np.isfinite(reach.min(axis=1)), chosen, -1)
    steps = zip(first.tolist(), second.tolist(), follower.tolist(), strict=True)
    after = {(i, j): (j, k) for i, j, k in steps if k >= 0}
    runs: set[tuple[int, ...]] = set()
    for begun in sorted(set(after) - set(after.values())) or sorted(after):
        run, here = list(begun), after.get(begun)
        while here is not None and here[1] not in run:
            run.append(here[1])
            here = after.get(here)
        # Each row is found from both of its ends.
        runs.add(tuple(run if run[0] < run[-1] else reversed(run)))
    return [list(run) for run in sorted(runs) if is_straight(middles[list(run)])]


def _relative(
    middles: FloatArray, start: IntArray, others: IntArray, step: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Measure points against lines along steps (n, 2) from other points.

    Parameters
    ----------
    start, others
        The points that the lines start from, shape (n,), and those that are looked at, (n, m).

    Returns
    -------
    off_line : FloatArray
        Distances from the start of the line, infinite on the line; shape (n, m).
    ahead : BoolArray
        True for those on the line, ahead of its start; shape (n, m).
    """
    away = middles[others] - middles[start][:, None]
    on = length(away)
    aside = np.abs(cross(away, step[:, None])) > BENT * on * length(step)[:, None]
    ahead = ~aside & ((away * step[:, None]).sum(axis=-1) > 0)
    return np.where(aside, on, np.inf), ahead


def _isolated(middles: FloatArray) -> list[list[int]]:
    """Points (n, 2) that are nearer to one another than any of them is to the rest."""
    part = {i: [i] for i in range(len(middles))}
    longest = dict.fromkeys(part, 0.0)
    clusters = []
    for between, *ends in _spanning_tree(middles):
        both = [part[end] for end in ends]
        clusters += [
            own for own in both if len(own) >= ROW and between >= ISOLATED * longest[own[0]]
        ]
        joined = [i for own in both for i in own]
        part.update(dict.fromkeys(joined, joined))
        longest[joined[0]] = between
    return clusters


def _spanning_tree(middles: FloatArray) -> list[tuple[float, int, int]]:
    """Return the shortest tree that joins points (n, 2): lengths and ends, shortest first.

    By Prim's algorithm. SciPy's clusters are the same and take a tenth of a second to load.
    """
    gap = length(middles[:, None] - middles)
    inside = np.zeros(len(gap), dtype=bool)
    inside[0] = True
    nearest, to = np.where(inside, np.inf, gap[0]), np.zeros(len(gap), dtype=int)
    links = []
    for _ in range(len(gap) - 1):
        new = int(nearest.argmin())
        links.append((float(nearest[new]), int(to[new]), new))
        inside[new] = True
        nearest[new] = np.inf
        closer = ~inside & (gap[new] < nearest)
        nearest[closer], to[closer] = gap[new, closer], new
    return sorted(links)


def along_spread(middles: FloatArray) -> IntArray:
    """Points (n, 2) in their order along the way that they spread most."""
    offset = middles - middles.mean(axis=0)
    along = np.linalg.eigh(offset.T @ offset)[1][:, 1]
    return np.argsort(offset @ along, kind="stable")


def is_straight(middles: FloatArray) -> bool:
    """Check that points (n, 2) are a row: three and more, which spread little across it."""
    if len(middles) < ROW:
        return False
    x, y = (middles - middles.mean(axis=0)).T
    mean, half = (x @ x + y @ y) / 2, float(np.hypot((x @ x - y @ y) / 2, x @ y))
    return bool(mean - half < NARROW**2 * (mean + half))
