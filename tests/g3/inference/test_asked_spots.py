"""Candidates that are only made where words ask for them, and the search reaches them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from g3.actions.grounding_candidates import object_groups
from g3.geometry.footprints import centre
from g3.geometry.plane import rotate
from tests.g3.actions.yards import box, forklift
from tests.g3.inference.test_coverage import (
    ANGLES,
    HALF_M,
    RELATIONS,
    SIDES,
    STARTS,
    check,
    check_plan,
    gaps,
    possible,
    seen,
    with_start,
    worlds,
)
from tests.worlds import scene


@pytest.mark.parametrize("side", SIDES)
@settings(max_examples=12, deadline=None)
@given(data=st.data(), metres=st.integers(4, 12))
def test_so_many_metres_to_a_side(side, data, metres):
    world = data.draw(worlds("ground", data.draw(st.sampled_from(STARTS))))
    mark = world.mark

    def right(points):
        off = seen(world, points[:, :2], centre(mark.prism))
        cosine = off @ np.array(SIDES[side]) / np.maximum(np.linalg.norm(off, axis=1), 1e-9)
        away = np.abs(gaps(points[:, :2], mark.prism) - metres - HALF_M) <= 1.0
        level = np.abs(points[:, 2]) < 0.1
        return level & away & (cosine >= np.cos(np.radians(46))) & possible(world, points)

    relation = f"{metres} metres {RELATIONS[side]}"
    around = box("around", "", (*centre(mark.prism), 0.0), (2 * metres + 2, 2 * metres + 2)).prism
    check(world, right, "OBJ(f = the crate)", relation, {"crate": [mark]}, around, 0.0)


@pytest.mark.parametrize("corner", [(1, 1), (1, -1), (-1, -1), (-1, 1)])
@settings(max_examples=8, deadline=None)
@given(data=st.data(), yaw=ANGLES)
def test_each_corner_of_a_thing(corner, data, yaw):
    trailer = box("trailer", "trailer", (0, 0, yaw), (6.0, 3.0), (0.4, 0.85))
    world = with_start(data.draw, data.draw(st.sampled_from(STARTS)), [trailer], 12.0)
    [tip] = rotate(np.array([[3.0, 1.5]]) * corner, np.array([yaw]))

    def right(points):
        near = np.linalg.norm(points[:, :2] - tip, axis=1) <= 2.0
        return near & (np.abs(points[:, 2]) < 0.1) & possible(world, points)

    things = {"trailer": [trailer]}
    check(world, right, "OBJ(f = the trailer)", "by the corner of", things, trailer.prism, 0.0)


@settings(max_examples=12, deadline=None)
@given(data=st.data())
def test_on_top_of_a_load_is_another_load(data):
    world = data.draw(worlds("ground", data.draw(st.sampled_from(("near", "far", "loaded")))))
    mark = world.mark
    at, top = centre(mark.prism), mark.prism.z_max

    def right(points):
        return (np.linalg.norm(points[:, :2] - at, axis=1) < 0.3) & (
            np.abs(points[:, 2] - top) < 0.1
        )

    check_plan(world.context, right, "OBJ(f = the crate)", "on top of", {"crate": [mark]})


@pytest.mark.parametrize("side", SIDES)
def test_where_the_robot_stands_is_free_once_it_has_left(side):
    mark, load = box("mark", "crate", (0, 0, 0)), box("load", "tire pallet", (14.0, 0, 0))
    x, y = 2.2 * np.array(SIDES[side])
    context = scene(mark, load, agent=forklift((x, y, 0.0)))

    def right(points):
        return np.linalg.norm(points - [x, y, 0.0], axis=1) < 0.7

    check_plan(context, right, "OBJ(f = the crate)", "near", {"crate": [mark]})


def crates(count: int, gap: float = 3.0):
    return [box(f"c{i}", "crate", (gap * i, 0, 0)) for i in range(count)]


@settings(max_examples=30, deadline=None)
@given(st.integers(4, 8), st.floats(1.6, 8.0), st.data())
def test_so_many_of_a_row_from_either_end(count, gap, data):
    some = data.draw(st.integers(3, count - 1))
    groups = object_groups(scene(*crates(count, gap), agent=forklift((0, -9, 0))), counts=(some,))
    found = {frozenset(getattr(o, "id", "") for o in group) for group in groups}
    first = {frozenset(f"c{i}" for i in part) for part in (range(some), range(count)[-some:])}
    assert first <= found
