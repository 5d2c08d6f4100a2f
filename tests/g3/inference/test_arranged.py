"""Rows, clusters, middles, ends and numbers, over generated arrangements.

Whatever the gaps and the direction, and wherever the robot stands.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from g3.actions.arrangements import arrangements_of
from g3.actions.grounding_candidates import object_groups
from g3.geometry.plane import rotate
from g3.groundings import FloatArray, PhysicalObject
from tests.g3.inference.ruled import of_sides
from tests.worlds import robot, scene, still, thing

ANGLES = st.floats(-3.1, 3.1)
GAPS = st.floats(1.4, 25.0)
SIZE = (1.2, 1.2)


@st.composite
def rows(draw: st.DrawFn, least: int = 3) -> FloatArray:
    """Middles of a row with any gap and in any direction, a little uneven; shape (n, 2)."""
    count, gap = draw(st.integers(least, 7)), draw(GAPS)
    noise = st.floats(-0.12, 0.12)
    uneven = np.array([[draw(noise), draw(noise)] for _ in range(count)])
    along = np.column_stack((np.arange(count), np.zeros(count))) + uneven
    yaw = draw(ANGLES)
    return gap * rotate(along, np.full(count, yaw))


def pallets(middles: FloatArray, prefix: str = "p", z: float = 0.0) -> list[PhysicalObject]:
    return [
        thing(f"{prefix}{i}", "pallet", float(x), float(y), SIZE, (z, z + 1))
        for i, (x, y) in enumerate(middles)
    ]


def ids(groups) -> set[frozenset[str]]:
    return {frozenset(getattr(o, "id", "") for o in group) for group in groups}


def candidates(*things: PhysicalObject) -> set[frozenset[str]]:
    return ids(object_groups(scene(*things)))


@settings(max_examples=60, deadline=None)
@given(rows(), st.floats(2.0, 6.0), ANGLES)
def test_a_row_is_one_whatever_its_gaps_and_what_stands_elsewhere(middles, away, way):
    gap = np.linalg.norm(middles[1] - middles[0])
    far = away * gap * np.array([np.cos(way), np.sin(way)])
    others = middles.mean(axis=0) + far * len(middles) + np.array([[0.0, 0.0], [0.3, 0.4]]) * gap
    things = [*pallets(middles), *pallets(others, "q")]
    assert frozenset(f"p{i}" for i in range(len(middles))) in candidates(*things)


@settings(max_examples=60, deadline=None)
@given(rows(), st.floats(1.0, 3.0))
def test_rows_beside_each_other_are_two(middles, apart):
    along = middles[-1] - middles[0]
    gap = np.linalg.norm(along) / (len(middles) - 1)
    across = np.array([-along[1], along[0]]) / np.linalg.norm(along)
    things = [*pallets(middles), *pallets(middles + apart * gap * across, "q")]
    found = candidates(*things)
    for prefix in "pq":
        assert frozenset(f"{prefix}{i}" for i in range(len(middles))) in found


@settings(max_examples=40, deadline=None)
@given(rows(), st.floats(0.4, 2.0))
def test_what_stands_on_a_deck_is_in_no_row_on_the_ground(middles, z):
    assert not arrangements_of([*pallets(middles[:2]), *pallets(middles[2:3], "q", z)]).rows


@settings(max_examples=40, deadline=None)
@given(st.integers(3, 6), GAPS, st.floats(3.0, 8.0), ANGLES, st.integers(0, 1000))
def test_a_cluster_is_one_whatever_its_gaps(count, gap, apart, way, seed):
    rng = np.random.default_rng(seed)
    angle = 2 * np.pi * (np.arange(count) + rng.uniform(-0.1, 0.1, count)) / count
    ring = gap * np.column_stack((np.cos(angle), np.sin(angle)))
    other = ring + apart * gap * np.array([np.cos(way), np.sin(way)]) * 1.5
    found = candidates(*pallets(ring), *pallets(other, "q"))
    for prefix in "pq":
        assert frozenset(f"{prefix}{i}" for i in range(count)) in found


def meant(things, words, agent, relation="", landmark=()):
    """The ids of the things that no rule speaks against."""
    cost = of_sides(things, agent, words, relation, landmark)
    return {t.id for t, c in zip(things, cost, strict=True) if c == 0}


@st.composite
def robots(draw: st.DrawFn, middles: FloatArray, seen_from: str) -> PhysicalObject:
    """A robot that looks anywhere, before a row, beyond its end, or anywhere about it."""
    along = middles[-1] - middles[0]
    length = float(np.linalg.norm(along))
    along = along / length
    across = np.array([-along[1], along[0]])
    away = draw(st.sampled_from((0.9, 5.0, 60.0)))
    side = draw(st.sampled_from((-1.0, 1.0)))
    middle = middles.mean(axis=0)
    if seen_from == "before":
        shift = draw(st.floats(-0.3, 0.3)) * length
        at = middle + shift * along + side * (away + 0.15 * length) * across
    else:
        at = middle + side * (length / 2 + away) * along
    return robot(still(float(at[0]), float(at[1]), yaw=draw(ANGLES)))


@pytest.mark.parametrize("seen_from", ["before", "beyond its end"])
@settings(max_examples=40, deadline=None)
@given(data=st.data())
def test_the_middle_one_of_a_row(seen_from, data):
    middles = data.draw(rows())
    assume(len(middles) % 2 == 1)
    agent = data.draw(robots(middles, seen_from))
    found = meant(pallets(middles), "the middle pallet", agent)
    assert found == {f"p{len(middles) // 2}"}


@settings(max_examples=40, deadline=None)
@given(st.integers(3, 8), GAPS, ANGLES, st.floats(0.0, 1.0), st.sampled_from((0.9, 5.0, 60.0)))
def test_the_middle_one_of_a_cluster(count, gap, turn, off, away):
    angle = turn + 2 * np.pi * np.arange(count) / count
    ring = gap * np.column_stack((np.cos(angle), np.sin(angle)))
    centre = 0.1 * gap * off * np.array([[1.0, 0.0]])
    agent = robot(still(-gap - away, 0.3 * gap, yaw=turn))
    assert meant(pallets(np.concatenate((ring, centre))), "the middle pallet", agent) == {
        f"p{count}"
    }


@settings(max_examples=40, deadline=None)
@given(GAPS, ANGLES, st.sampled_from((0.9, 5.0, 60.0)))
def test_the_middle_one_of_a_triangle_is_so_for_who_looks_at_it(gap, heading, away):
    corners = gap * np.array([[0.0, 1.0], [0.9, 0.0], [0.0, -1.0]])
    agent = robot(still(-gap - away, 0.0, yaw=heading))
    assert meant(pallets(corners), "the middle pallet", agent) == {"p1"}


@pytest.mark.parametrize("seen_from", ["before", "beyond its end"])
@settings(max_examples=40, deadline=None)
@given(data=st.data())
def test_the_end_of_a_row_is_either_end(seen_from, data):
    middles = data.draw(rows())
    agent = data.draw(robots(middles, seen_from))
    things = pallets(middles)
    ends = {"p0", f"p{len(middles) - 1}"}
    assert meant(things, "the pallet", agent, "at the end of", tuple(things)) == ends
    assert meant(things, "the end pallet", agent) == ends


@pytest.mark.parametrize("side", ["left", "right"])
@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_things_of_a_row_are_counted_from_a_side(side, data):
    middles = data.draw(rows())
    agent = data.draw(robots(middles, "before"))
    local = rotate(middles - agent.trajectory.xyz[0, :2], np.zeros(len(middles)))
    ahead = local.mean(axis=0)
    bearing = rotate(local, np.full(len(local), -np.arctan2(ahead[1], ahead[0])))
    order = np.argsort(np.arctan2(bearing[:, 1], bearing[:, 0]))
    order = order[::-1] if side == "left" else order
    things = pallets(middles)
    for number, word in enumerate(("first", "second", "third")):
        words = f"the {word} pallet from the {side}"
        assert meant(things, words, agent) == {f"p{order[number]}"}
    assert meant(things, f"the {side}most pallet", agent) == {f"p{order[0]}"}
