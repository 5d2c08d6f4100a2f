from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from shapely import MultiPoint

from g3.features.avs import attention
from g3.features.avs.vector_sums import avs_directions, footprints
from g3.geometry import plane
from g3.geometry.plane import gap
from g3.groundings import FloatArray


def boxes(count: int, seed: int) -> FloatArray:
    """Upright rectangles, each with its last corner repeated."""
    rng = np.random.default_rng(seed)
    unit = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0, 1)])
    sizes, places = rng.uniform(0.5, 4, (count, 1, 2)), rng.uniform(-9, 9, (count, 1, 2))
    corners: FloatArray = unit * sizes + places
    return corners


@pytest.mark.parametrize("count", [0, 1, 700])
def test_distances_are_shapelys_whatever_the_size_of_blocks(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    points = np.zeros((3, 5, 2))
    a = np.concatenate((boxes(count, 1), points))
    b = np.concatenate((boxes(count, 2), points + 1))
    hulls = ([MultiPoint(corners).convex_hull for corners in some] for some in (a, b))
    expected = np.array([one.distance(other) for one, other in zip(*hulls, strict=True)])
    backwards = np.arange(len(a))[::-1]
    for block in (300, 4096):
        monkeypatch.setattr(plane, "_BLOCK", block)
        assert_allclose(gap(a, b), expected, atol=1e-9)
        assert_allclose(gap(a, b, (backwards, backwards)), expected[::-1], atol=1e-9)
    assert gap(a[:0], b[:0]).shape == (0,)


def test_directions_are_the_same_in_blocks_of_any_size(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(11)
    flat = np.array([[(0, 0), (3, 0), (3, 0), (3, 0), (3, 0)]])
    shapes = np.concatenate((boxes(20, 3), flat))
    landmarks = footprints(shapes, rng.integers(len(shapes), size=900))
    points, yaw = rng.uniform(-15, 15, (900, 2)), rng.uniform(-4, 4, (2, 900))
    expected = avs_directions(points, landmarks, yaw)
    monkeypatch.setattr(attention, "BLOCK", 500)
    assert_allclose(avs_directions(points, landmarks, yaw), expected, atol=1e-6)
    assert expected.std() > 0.1


def test_pairs_may_be_named_by_rows() -> None:
    a, b = boxes(4, 4), boxes(3, 5)
    first, second = np.meshgrid(np.arange(4), np.arange(3))
    rows = first.ravel(), second.ravel()
    assert_array_equal(gap(a, b, rows), gap(a[rows[0]], b[rows[1]]))


def test_arrays_need_not_be_contiguous_or_writable() -> None:
    both = np.broadcast_to(boxes(1, 8), (4, 5, 2))
    assert_array_equal(gap(both, both[:, ::-1][:, ::-1]), np.zeros(4))
    row, points = np.array([[0, 0], [1, 0], [1, 0]])[:, 0], np.ones((3, 4))[:, ::2]
    yaw = np.broadcast_to(0.5, (2, 3))
    found = avs_directions(points, footprints(boxes(2, 9), row), yaw)
    assert_array_equal(
        found, avs_directions(points.copy(), footprints(boxes(2, 9), row.copy()), yaw)
    )


def test_threads_may_compute_at_once() -> None:
    a, b = boxes(500, 6), boxes(500, 7)
    with ThreadPoolExecutor(4) as threads:
        for found in threads.map(lambda _: gap(a, b), range(8)):
            assert_array_equal(found, gap(a, b))
