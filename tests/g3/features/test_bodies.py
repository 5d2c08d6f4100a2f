from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from g3.features.bodies import MAX_CORNERS, MAX_MEMBERS, SAMPLES, moved_corners, pack, positions_at
from g3.geometry.plane import area, centroid, convex_hull
from g3.groundings import Grounding, Path, Place, Prism, Trajectory
from tests.strategies import contexts, groundings, trajectories
from tests.worlds import line, log, prism, thing

groups = contexts().flatmap(
    lambda context: st.lists(
        st.lists(groundings(context), min_size=1, max_size=3).map(tuple), min_size=1, max_size=4
    )
)


@settings(max_examples=25)
@given(groups)
def test_a_batch_is_packed_as_its_bodies_are(drawn: list[tuple[Grounding, ...]]) -> None:
    together = pack(drawn)
    for i, group in enumerate(drawn):
        alone = pack([group])
        assert_allclose(centroid(together.corners)[i], centroid(alone.corners)[0], atol=1e-9)
        assert_allclose(area(together.corners)[i], area(alone.corners)[0], atol=1e-9)
        for name in ("z_min", "z_max", "count", "moves"):
            assert getattr(together, name)[i] == getattr(alone, name)[0]
        assert_array_equal(together.members[i], alone.members[0])
        for name in ("t", "xyz", "yaw"):
            assert_allclose(getattr(together, name)[i], getattr(alone, name)[0], atol=1e-6)
        named = {n for n, has in zip(together.label_names, together.labels[i], strict=True) if has}
        assert named == set(alone.label_names)


@given(trajectories())
def test_resampling_keeps_the_ends_and_spreads_poses_evenly(trajectory: Trajectory) -> None:
    body = pack([(Path(trajectory),)])
    assert_allclose(body.xyz[0, [0, -1]], trajectory.xyz[[0, -1]], atol=1e-6)
    turned = body.yaw[0, [0, -1]] - trajectory.yaw[[0, -1]]
    assert_allclose(np.sin(turned), 0, atol=1e-6)
    assert_allclose(np.cos(turned), 1, atol=1e-6)
    assert (np.diff(body.t[0]) >= -1e-9).all()
    assert body.moves[0] == (len(trajectory) > 1)


def test_resampling_counts_a_turn_on_the_spot_as_way() -> None:
    # 2 m ahead, then a turn of 2 rad: half of the poses stand at the end.
    path = log([(0, 0), (2, 0), (2, 0)], yaw=[0, 0, 2])
    body = pack([(Path(path),)])
    middle = SAMPLES // 2
    assert_allclose(body.xyz[0, : middle + 1, 0], np.linspace(0, 2, middle + 1))
    assert_allclose(body.yaw[0, middle:], np.linspace(0, 2, SAMPLES - middle))
    assert_allclose(body.t[0, [0, middle, -1]], [0, 1, 2])


def test_headings_do_not_jump_by_a_full_turn() -> None:
    path = log(line((0, 0), (3, 0), 4), yaw=[3.0, 3.1, -3.1, -3.0])
    assert_allclose(pack([(Path(path),)]).yaw[0, -1], 2 * np.pi - 3.0)


def test_positions_are_those_of_the_last_pose_logged() -> None:
    moving = thing("a", "pallet", 0, 0, trajectory=log([(0, 0), (1, 0), (5, 0)], t=[10, 12, 20]))
    still = thing("b", "pallet", 7, 7)
    bodies = pack([(still,), (moving,)])
    times = np.array([[0.0, 10.0, 11.9, 12.0, 19.0, 20.0, 99.0]])
    xyz, yaw = positions_at(bodies, np.array([1]), times)
    assert_array_equal(xyz[0, :, 0], [0, 0, 0, 1, 1, 5, 5])
    assert_array_equal(yaw, np.zeros((1, 7)))
    xyz, _ = positions_at(bodies, np.array([0]), times)
    assert_array_equal(xyz[0, :, :2], np.full((7, 2), 7))


def test_a_plural_is_one_body() -> None:
    a, b = thing("a", "tire pallet", 0, 0), thing("b", "box pallet", 10, 0, z=(1, 3))
    body = pack([(a, b)])
    assert body.count[0] == 2
    assert_allclose(area(body.corners), 12 * 2)
    assert (body.z_min[0], body.z_max[0]) == (0, 3)
    assert_allclose(body.members[0, :2], [[0, 0], [10, 0]])
    assert np.isnan(body.members[0, 2:]).all()
    assert body.label_names == ("box", "pallet", "tire")
    assert_array_equal(body.labels, [[True, True, True]])
    assert_array_equal(body.shared_labels, [[False, True, False]])


def test_more_things_than_members_are_looked_at_are_cut_off() -> None:
    many = tuple(thing(str(i), "pallet", 3 * i, 0) for i in range(MAX_MEMBERS + 2))
    assert pack([many]).members.shape == (1, MAX_MEMBERS, 2)


def test_a_plural_moves_as_the_thing_that_moves_most() -> None:
    # However many poses of it were logged.
    shaking = thing("a", "pallet", 0, 0, trajectory=log(line((0, 0), (0.1, 0), 50)))
    driven = thing("b", "pallet", 5, 0, trajectory=log([(5, 0), (9, 0)]))
    for group in ((shaking, driven), (driven, shaking)):
        assert_allclose(pack([group]).xyz[0, -1, :2], [9, 0])


def test_round_footprints_keep_the_corners_that_matter() -> None:
    angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    circle = Place(Prism(np.column_stack((np.cos(angle), np.sin(angle))), 0, 1))
    body = pack([(circle,)])
    assert body.corners.shape == (1, MAX_CORNERS, 2)
    assert_allclose(area(body.corners), np.pi, rtol=0.15)


def test_a_footprint_with_a_dent_is_made_convex() -> None:
    dented = Place(Prism(np.array([[0, 0], [4, 0], [4, 4], [2, 1], [0, 4]]), 0, 1))
    body = pack([(dented,)])
    assert_allclose(area(body.corners), 16)
    assert_allclose(body.xyz[0, 0], [2, 2, 0])


@pytest.mark.parametrize("yaw", [0.0, 0.7, np.pi / 2, -2.0])
def test_a_paths_footprint_turns_with_it(yaw: float) -> None:
    # Straight ahead for 6 m and 2 m to the left.
    ahead, left = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
    path = Path(log([0 * ahead, 6 * ahead, 6 * ahead + 2 * left], yaw=yaw))
    corners = pack([(path,)]).corners
    assert_allclose(area(corners), 12)
    assert_allclose(centroid(corners), [3 * ahead + left], atol=1e-9)


def test_the_order_of_corners_does_not_matter() -> None:
    place = Place(prism(3, 4))
    clockwise = replace(place, prism=replace(place.prism, xy=place.prism.xy[::-1]))
    bodies = pack([(place,), (clockwise,)])
    assert_array_equal(bodies.corners[0], bodies.corners[1])
    assert_array_equal(bodies.corners[0], convex_hull(place.prism.xy))


def test_moved_corners_are_carried_and_turned() -> None:
    start, pose = np.array([[1.0, 0.0, 0.0]]), np.array([[5.0, 5.0, np.pi / 2]])
    corners = np.array([[[2.0, 0.0], [1.0, 3.0], [0.0, 0.0]]])
    assert_allclose(moved_corners(corners, start, pose), [[[5, 6], [2, 5], [5, 4]]])


def test_nothing_packs_to_nothing() -> None:
    bodies = pack([])
    assert bodies.corners.shape[0] == len(bodies.t) == 0
