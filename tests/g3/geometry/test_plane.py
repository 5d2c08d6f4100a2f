from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from g3.geometry.plane import (
    area,
    centroid,
    contains_point,
    convex_hull,
    gap,
    intersection_area,
    point_gap,
    rotate,
    wrap,
)
from g3.groundings import FloatArray

SLOTS = 8
SQUARE = [(0, 0), (2, 0), (2, 2), (0, 2)]


def pad(corners: FloatArray) -> FloatArray:
    """A footprint in the module's form: the last corner repeated, a batch of one."""
    return np.concatenate([corners, np.repeat(corners[-1:], SLOTS - len(corners), axis=0)])[None]


def footprint(*corners: tuple[float, float]) -> FloatArray:
    return pad(np.array(corners, dtype=float))


def shape(polygon: FloatArray) -> shapely.Geometry:
    """What shapely makes of the corners, whether a polygon, a segment or a point."""
    return shapely.MultiPoint(polygon[0]).convex_hull


coordinates = st.integers(-40, 40).map(lambda n: n / 8)
points = st.tuples(coordinates, coordinates).map(np.array)
moves = st.tuples(st.floats(-4, 4), st.floats(-50, 50), st.floats(-50, 50))


@st.composite
def convex(draw: st.DrawFn, min_points: int = 1) -> FloatArray:
    """Convex footprints on a grid, where touching and degenerate ones are frequent."""
    drawn = draw(st.lists(points, min_size=min_points, max_size=6))
    hull = convex_hull(np.array(drawn))
    return pad(hull[:SLOTS])


solid = convex(min_points=3).filter(lambda polygon: area(polygon)[0] > 0)


def moved(polygon: FloatArray, move: tuple[float, float, float]) -> FloatArray:
    angle, x, y = move
    return rotate(polygon, np.full(polygon.shape[:-1], angle)) + np.array([x, y])


@given(st.lists(points, min_size=1, max_size=12))
def test_convex_hull_is_shapelys(drawn: list[FloatArray]) -> None:
    hull = convex_hull(np.array(drawn))
    expected = shapely.MultiPoint(np.array(drawn)).convex_hull
    assert shapely.MultiPoint(hull).convex_hull.equals(expected)
    if isinstance(expected, shapely.Polygon):
        assert len(hull) == len(expected.exterior.coords) - 1
        assert area(pad(hull) if len(hull) <= SLOTS else hull[None])[0] > 0


@given(convex())
def test_area_is_shapelys(polygon: FloatArray) -> None:
    assert_allclose(area(polygon), shape(polygon).area, atol=1e-9)


@given(convex())
def test_centroid_is_shapelys(polygon: FloatArray) -> None:
    expected = shape(polygon).centroid
    assert_allclose(centroid(polygon)[0], (expected.x, expected.y), atol=1e-9)


@given(convex(), convex())
def test_intersection_area_is_shapelys_and_symmetric(a: FloatArray, b: FloatArray) -> None:
    expected = shape(a).intersection(shape(b)).area
    assert_allclose(intersection_area(a, b), expected, atol=1e-9)
    assert_allclose(intersection_area(b, a), expected, atol=1e-9)


@given(
    st.integers(2, 5), st.sampled_from([1.2, 1.5, 2.0, 3.3]), st.floats(-4, 4), points, st.data()
)
def test_a_thing_of_a_row_lies_in_the_hull_of_the_row(
    count: int, step: float, yaw: float, point: FloatArray, data: st.DataObject
) -> None:
    """Their sides are on one line but for rounding, which may seem to cut it several times."""
    side = np.array([[-0.6, -0.5], [0.6, -0.5], [0.6, 0.5], [-0.6, 0.5]])
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    row = [(side + np.array([i * step, 0.0])) @ turn.T + 10 * point for i in range(count)]
    hull = convex_hull(np.concatenate(row))[None]  # rounding may leave corners on its sides
    thing = data.draw(st.sampled_from(row))[None]
    assert_allclose(intersection_area(hull, thing), 1.2, atol=1e-9)
    assert_allclose(intersection_area(thing, hull), 1.2, atol=1e-9)


ROW_HULL = np.array(
    [
        [
            [-0.0472794240637564, -4.828682656348247],
            [0.5655490510534333, -5.618898614226559],
            [1.5138082005074092, -4.883504444085932],
            [4.121520861505843, -2.8611704761992063],
            [6.729233522504276, -0.8388365083124807],
            [6.116405047387086, -0.04862055043416724],
            [5.16814589793311, -0.7840147205747945],
        ]
    ]
)
ROW_THING = np.array(
    [
        [
            [5.7809743730503005, -1.574230678453108],
            [6.729233522504276, -0.8388365083124807],
            [6.116405047387086, -0.04862055043416724],
            *[[5.16814589793311, -0.7840147205747945]] * 4,
        ]
    ]
)


def test_sides_that_rounding_cuts_several_times() -> None:
    """A hull and a thing of it, found by trying many: clipping them was an IndexError."""
    hull, thing = ROW_HULL, ROW_THING
    assert_allclose(intersection_area(hull, thing), 1.2, atol=1e-9)
    assert_allclose(intersection_area(thing, hull), 1.2, atol=1e-9)


@given(convex(), convex())
def test_gap_is_shapelys_and_symmetric(a: FloatArray, b: FloatArray) -> None:
    expected = shape(a).distance(shape(b))
    assert_allclose(gap(a, b), expected, atol=1e-9)
    assert_allclose(gap(b, a), expected, atol=1e-9)


@given(convex(), points)
def test_contains_point_is_shapelys_covers(polygon: FloatArray, point: FloatArray) -> None:
    assert contains_point(polygon, point[None])[0] == shape(polygon).covers(shapely.Point(point))


@given(convex(), st.lists(points, min_size=1, max_size=5))
def test_point_gap_is_shapelys(polygon: FloatArray, drawn: list[FloatArray]) -> None:
    expected = [shape(polygon).distance(shapely.Point(p)) for p in drawn]
    assert_allclose(point_gap(np.array([drawn]), polygon)[0], expected, atol=1e-9)


@given(solid, solid, points, moves)
def test_nothing_depends_on_where_a_scene_lies_or_how_it_is_turned(
    a: FloatArray, b: FloatArray, point: FloatArray, move: tuple[float, float, float]
) -> None:
    there_a, there_b = moved(a, move), moved(b, move)
    there_point = moved(point[None], move)
    assert_allclose(area(there_a), area(a), atol=1e-9)
    assert_allclose(centroid(there_a), moved(centroid(a), move), atol=1e-9)
    assert_allclose(intersection_area(there_a, there_b), intersection_area(a, b), atol=1e-9)
    assert_allclose(gap(there_a, there_b), gap(a, b), atol=1e-9)
    assert_allclose(
        point_gap(there_point[None], there_a), point_gap(point[None, None], a), atol=1e-9
    )


@given(solid, moves)
def test_a_polygon_shares_all_of_itself_with_itself(
    polygon: FloatArray, move: tuple[float, float, float]
) -> None:
    there = moved(polygon, move)
    assert_allclose(intersection_area(there, there), area(polygon), atol=1e-9)
    assert gap(there, there)[0] == 0


@given(st.lists(st.tuples(convex(), convex()), min_size=1, max_size=4))
def test_a_batch_gives_what_its_rows_give(pairs: list[tuple[FloatArray, FloatArray]]) -> None:
    a, b = (np.concatenate(side) for side in zip(*pairs, strict=True))
    for function in (intersection_area, gap):
        assert_allclose(function(a, b), np.concatenate([function(*pair) for pair in pairs]))
    for function in (area, centroid):
        assert_allclose(function(a), np.concatenate([function(one) for one, _ in pairs]))


@given(convex())
def test_repeated_corners_change_nothing(polygon: FloatArray) -> None:
    more = np.concatenate([polygon, np.repeat(polygon[:, -1:], 3, axis=1)], axis=1)
    other = footprint(*SQUARE)
    assert_allclose(area(more), area(polygon))
    assert_allclose(centroid(more), centroid(polygon))
    assert_allclose(gap(more, other), gap(polygon, other))
    assert_allclose(intersection_area(more, other), intersection_area(polygon, other))


def test_golden_values_of_a_square() -> None:
    square = footprint(*SQUARE)
    assert area(square) == 4
    assert_allclose(centroid(square), [[1, 1]])
    # Shifted by (1, 1) it shares a unit square; by (5, 6) it is 3 and 4 m away.
    assert_allclose(intersection_area(square, square + 1), 1)
    assert_allclose(gap(square, square + np.array([5, 6])), 5)
    assert_allclose(gap(square, square + np.array([2, 0])), 0)
    inside = [(1, 1), (0, 0), (2, 1), (2.1, 1), (-1, -1)]
    assert [contains_point(square, np.array([p]))[0] for p in inside] == [True] * 3 + [False] * 2
    assert_allclose(point_gap(np.array([inside]), square), [[0, 0, 0, 0.1, np.sqrt(2)]])


def test_golden_centroid_of_a_triangle() -> None:
    assert_allclose(centroid(footprint((0, 0), (3, 0), (0, 6))), [[1, 2]])


def test_area_keeps_its_digits_far_from_the_origin() -> None:
    far = footprint(*SQUARE) + np.array([450_000.0, 5_400_000.0])
    assert_allclose(area(far), 4, rtol=1e-9)
    assert_allclose(centroid(far), [[450_001, 5_400_001]], rtol=1e-15)


@pytest.mark.parametrize(
    ("polygon", "point", "distance"),
    [
        (footprint((1, 1)), (4, 5), 5.0),
        (footprint((0, 0), (2, 0)), (5, 0), 3.0),
        (footprint((0, 0), (2, 0)), (1, 2), 2.0),
        (footprint((0, 0), (2, 0)), (1, 0), 0.0),
    ],
)
def test_points_and_segments_are_as_far_as_they_look(
    polygon: FloatArray, point: tuple[float, float], distance: float
) -> None:
    at = np.array([point], dtype=float)
    assert_allclose(point_gap(at[None], polygon), [[distance]])
    assert_allclose(gap(polygon, footprint(point)), distance)
    assert contains_point(polygon, at)[0] == (distance == 0)


@given(st.floats(-100, 100))
def test_wrap_keeps_the_direction(angle: float) -> None:
    (wrapped,) = wrap(np.array([angle]))
    assert -np.pi <= wrapped < np.pi
    assert_allclose([np.cos(wrapped), np.sin(wrapped)], [np.cos(angle), np.sin(angle)], atol=1e-9)


def test_rotate_turns_counter_clockwise() -> None:
    turned = rotate(np.array([[1.0, 0.0], [0.0, 2.0]]), np.array([np.pi / 2, np.pi]))
    assert_allclose(turned, [[0, 1], [0, -2]], atol=1e-15)
