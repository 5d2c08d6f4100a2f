from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from g3.features.avs import attention, attention_arrays, vector_sums
from g3.features.avs.vector_sums import avs_directions, footprints
from g3.geometry import plane, separation
from g3.geometry.compiled import compiled
from g3.geometry.plane import corner_count, gap
from g3.groundings import FloatArray


def boxes(count: int, seed: int) -> FloatArray:
    """Upright rectangles, each with its last corner repeated."""
    rng = np.random.default_rng(seed)
    unit = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0, 1)])
    sizes, places = rng.uniform(0.5, 4, (count, 1, 2)), rng.uniform(-9, 9, (count, 1, 2))
    corners: FloatArray = unit * sizes + places
    return corners


def as_python(patch: pytest.MonkeyPatch, module: object) -> None:
    """Let a module's functions run as they are written."""
    for name, function in vars(module).items():
        if hasattr(function, "py_func"):
            patch.setattr(module, name, function.py_func)


def test_machine_code_of_distances_does_what_is_written(monkeypatch: pytest.MonkeyPatch) -> None:
    a, b = boxes(6, 1), np.concatenate((boxes(5, 2), np.zeros((1, 5, 2))))
    expected = gap(a, b)
    as_python(monkeypatch, separation)
    written, row = np.empty(6), np.arange(6)
    separation.separations((a, corner_count(a), row), (b, corner_count(b), row), written)
    assert_allclose(expected, written, atol=1e-12)


def test_machine_code_of_directions_does_what_is_written(monkeypatch: pytest.MonkeyPatch) -> None:
    landmarks = footprints(boxes(2, 3), np.array([0, 1, 1]))
    points, yaw = np.array([[3.0, 1.0], [-4.0, 2.0], [0.5, 9.0]]), np.array([[0.1, 0.7, -2.0]])
    expected = avs_directions(points, landmarks, yaw)
    as_python(monkeypatch, attention)
    monkeypatch.setattr(attention, "BLOCK", 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        written = avs_directions(points, landmarks, yaw)
    assert_allclose(expected, written, atol=1e-4)


@pytest.mark.parametrize("count", [0, 1, 700])
def test_arrays_give_the_same_distances(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    points = np.zeros((3, 5, 2))
    a = np.concatenate((boxes(count, 1), points))
    b = np.concatenate((boxes(count, 2), points + 1))
    expected, backwards = gap(a, b), np.arange(len(a))[::-1]
    monkeypatch.setattr(plane, "HAS_COMPILER", False)
    monkeypatch.setattr(plane, "_BLOCK", 300)
    assert_allclose(gap(a, b), expected, atol=1e-12)
    assert_allclose(gap(a, b, (backwards, backwards)), expected[::-1], atol=1e-12)
    assert gap(a[:0], b[:0]).shape == (0,)


def test_arrays_give_the_same_directions(monkeypatch: pytest.MonkeyPatch) -> None:
    """Single precision may round to the next hundredth of a degree, which is 0.00006."""
    rng = np.random.default_rng(11)
    flat = np.array([[(0, 0), (3, 0), (3, 0), (3, 0), (3, 0)]])
    shapes = np.concatenate((boxes(20, 3), flat))
    landmarks = footprints(shapes, rng.integers(len(shapes), size=900))
    points, yaw = rng.uniform(-15, 15, (900, 2)), rng.uniform(-4, 4, (2, 900))
    expected = avs_directions(points, landmarks, yaw)
    monkeypatch.setattr(vector_sums, "HAS_COMPILER", False)
    monkeypatch.setattr(attention_arrays, "BLOCK", 500)
    found = avs_directions(points, landmarks, yaw)
    assert_allclose(found, expected, atol=2e-3)
    assert np.mean(np.abs(found - expected) > 1e-4) < 0.01
    assert expected.std() > 0.1


def test_exponentials_and_angles_are_as_exact_as_single_precision() -> None:
    for x in (0.0, 0.03, 0.5, 1.0, 7.3, 80.0):
        assert_allclose(attention.exp_minus(np.float32(x)), np.exp(-x), rtol=1e-6)
    for degrees in range(0, 181, 15):
        turn = np.radians(degrees)
        found = attention.angle(np.float32(np.sin(turn)), np.float32(np.cos(turn)))
        assert_allclose(found, turn, atol=1e-6)


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


def test_what_cannot_be_kept_is_compiled_all_the_same() -> None:
    scope: dict[str, object] = {}
    exec("def double(x): return 2 * x", scope)  # a function without a file
    double = compiled("f8(f8)")(scope["double"])  # type: ignore[type-var]
    assert double(1.5) == 3.0  # type: ignore[operator]
