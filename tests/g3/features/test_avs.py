from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from g3.features.avs.vector_sums import avs_directions, footprints
from g3.geometry.plane import rotate
from g3.groundings import FloatArray
from tests.worlds import prism

SQUARE = prism(0, 0).xy
FRONT, LEFT, BACK, RIGHT = range(4)

scenes = st.tuples(
    st.tuples(st.floats(-9, 9), st.floats(-9, 9)),
    st.tuples(st.floats(0.3, 6), st.floats(0.3, 6)),
    st.floats(-3, 3),
)


def avs(point: tuple[float, float], landmark: FloatArray, degrees: float) -> float:
    """AVS in one direction, counter-clockwise from +x."""
    return float(frame(np.array(point, dtype=float), landmark, np.radians(degrees))[FRONT])


def frame(point: FloatArray, landmark: FloatArray, yaw: float) -> FloatArray:
    return avs_directions(point[None], footprints(landmark[None]), np.array([[yaw]]))[0]


@pytest.mark.parametrize(
    ("deviation", "degree"),
    # 1.007 - 0.006 a degree, at most 1 and at least 0
    [(0, 1.0), (1, 1.0), (30, 0.827), (45, 0.737), (90, 0.467), (150, 0.107), (180, 0.0)],
)
def test_a_landmark_of_one_point_gives_the_fitted_line(deviation: float, degree: float) -> None:
    point = np.zeros((4, 2))
    assert_allclose(avs((3, 0), point, deviation), degree, atol=1e-9)
    assert_allclose(avs((3, 0), point, -deviation), degree, atol=1e-9)


def test_golden_values_of_a_square_straight_on() -> None:
    # By symmetry the vectors add up along +x: no deviation from +x, 180 degrees from -x.
    assert avs((5, 0), SQUARE, 0) == 1.0
    assert avs((5, 0), SQUARE, 180) == 0.0


@pytest.mark.parametrize(("degrees", "degree"), [(45, 0.737), (-45, 0.737), (90, 0.467)])
def test_from_afar_a_square_is_a_point(degrees: float, degree: float) -> None:
    assert_allclose(avs((1e5, 0), SQUARE, degrees), degree, atol=1e-3)


def test_attention_rests_on_the_near_side_of_a_long_landmark() -> None:
    wall = prism(0, 0, size=(20, 1)).xy
    # Straight above the end of the wall; from its centre it would be 72.5 degrees aside.
    from_the_centre = 1.007 - 0.006 * np.degrees(np.arctan2(9.5, 3))
    assert avs((9.5, 3), wall, 90) > from_the_centre + 0.2
    assert avs((0, 3), wall, 90) == 1.0
    assert avs((30, 1), wall, 90) < 0.5


def test_it_is_the_sum_over_the_footprint() -> None:
    # Regier and Carlson's sum written out over a fine raster of the landmark.
    x, y = np.meshgrid(np.linspace(-2, 2, 81), np.linspace(-1, 1, 41))
    landmark, inside = prism(0, 0, size=(4, 2)).xy, np.column_stack((x.ravel(), y.ravel()))
    for figure in ((1.0, 2.5), (-3.0, 4.0), (4.0, 1.5), (6.0, -2.0)):
        focus = np.array([np.clip(figure[0], -2, 2), 1.0])
        sigma = np.linalg.norm(figure - focus)
        attention = np.exp(-np.linalg.norm(inside - focus, axis=1) / sigma)
        across, along = (attention[:, None] * (np.array(figure) - inside)).sum(axis=0)
        expected = 1.007 - 0.006 * np.degrees(np.arctan2(abs(across), along))
        assert_allclose(avs(figure, landmark, 90), min(expected, 1), atol=2e-3)


@given(scenes, st.floats(-4, 4), st.floats(0.1, 10))
def test_turning_or_scaling_the_whole_scene_changes_nothing(
    drawn: tuple[tuple[float, float], tuple[float, float], float], angle: float, scale: float
) -> None:
    figure, size, yaw = drawn
    point, landmark = np.array(figure), prism(0, 0, size).xy
    turned = rotate(point, np.array(angle)), rotate(landmark, np.full(4, angle))
    expected = frame(point, landmark, yaw)
    assert_allclose(frame(*turned, yaw + angle), expected, atol=1e-4)
    assert_allclose(frame(point * scale, landmark * scale, yaw), expected, atol=1e-4)
    assert_allclose(frame(point + 100, landmark + 100, yaw), expected, atol=1e-4)
    assert ((expected >= 0) & (expected <= 1)).all()


@given(scenes)
def test_a_mirror_swaps_left_and_right(
    drawn: tuple[tuple[float, float], tuple[float, float], float],
) -> None:
    figure, size, yaw = drawn
    point = np.array(figure)
    landmark, mirror = prism(0.5, 0.2, size).xy, np.array([1, -1])
    original = frame(point, landmark, yaw)
    # Mirrored corners run clockwise: turn their order back.
    mirrored = frame(point * mirror, (landmark * mirror)[::-1], -yaw)
    assert_allclose(mirrored[[FRONT, RIGHT, BACK, LEFT]], original, atol=1e-4)


@given(scenes)
def test_half_a_turn_swaps_front_and_back(
    drawn: tuple[tuple[float, float], tuple[float, float], float],
) -> None:
    figure, size, yaw = drawn
    point, landmark = np.array(figure), prism(0.5, 0.2, size).xy
    turned = frame(point, landmark, yaw + np.pi)
    assert_allclose(turned[[BACK, RIGHT, FRONT, LEFT]], frame(point, landmark, yaw), atol=1e-4)


@given(scenes)
def test_repeated_corners_change_nothing(
    drawn: tuple[tuple[float, float], tuple[float, float], float],
) -> None:
    figure, size, yaw = drawn
    landmark = prism(0, 0, size).xy
    padded = np.concatenate([landmark, np.repeat(landmark[-1:], 4, axis=0)])
    point = np.array(figure)
    assert_allclose(frame(point, padded, yaw), frame(point, landmark, yaw), atol=1e-9)


def test_a_figure_at_the_centre_or_on_the_border_has_degrees() -> None:
    for point in (np.zeros(2), np.array([1.0, 0.0]), np.array([1.0, 1.0])):
        assert np.isfinite(frame(point, SQUARE, 0.0)).all()


def test_slight_tilts_change_degrees_slightly() -> None:
    # Where attention rests must not jump between the ends of a side along the direction.
    point, wall = np.array([6.0, 2.0]), prism(0, 0, size=(4, 10)).xy
    values = [frame(point, rotate(wall, np.full(4, a)), 0.0) for a in (-1e-7, 0.0, 1e-7)]
    assert_allclose(values, [values[1]] * 3, atol=1e-4)


def test_a_line_is_seen_as_a_thin_strip() -> None:
    line = np.array([[-2.0, 0.0], [2.0, 0.0], [2.0, 0.0], [2.0, 0.0]])
    strip = prism(0, 0, size=(4, 0.01)).xy
    for figure in ((1.0, 2.5), (-3.0, 4.0), (6.0, -2.0)):
        expected = frame(np.array(figure), strip, 0.7)
        assert_allclose(frame(np.array(figure), line, 0.7), expected, atol=5e-3)


@pytest.mark.parametrize("corners", [1, 2, 3])
def test_lines_and_points_need_no_more_corners_than_they_have(corners: int) -> None:
    line = np.array([[-1.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 0.0]])
    whole = line if corners > 1 else line[:1].repeat(4, axis=0)
    figure = np.array([2.0, 3.0])
    assert_allclose(frame(figure, line[:corners], 0.2), frame(figure, whole, 0.2), atol=1e-9)


def test_landmarks_with_few_and_many_corners_are_seen_together_as_alone() -> None:
    angle = 2 * np.pi * np.arange(7) / 7
    round_one = 2 * np.column_stack((np.cos(angle), np.sin(angle)))
    square = np.concatenate([SQUARE, np.repeat(SQUARE[-1:], 3, axis=0)])
    figure = np.array([[3.0, 1.0], [3.0, 1.0], [-1.0, 4.0]])
    row = np.array([1, 0, 1])
    both = footprints(np.stack((square, round_one)), row)
    together = avs_directions(figure, both, np.full((1, 3), 0.3))
    alone = [frame(f, (square, round_one)[i], 0.3) for f, i in zip(figure, row, strict=True)]
    assert_allclose(together, alone, atol=1e-4)
