"""Outlines are carried on from picture to picture."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, TypeAlias

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from corpus_tools.video.outline_tracking import carry_on, thinned

Film: TypeAlias = Iterator[tuple[float, NDArray[np.uint8]]]

WIDTH, HEIGHT = 640, 360
BACKGROUND = cv2.GaussianBlur(
    np.random.default_rng(1).integers(60, 120, (HEIGHT, WIDTH, 3), np.uint8), (0, 0), 4
)
THING = np.random.default_rng(2).integers(0, 255, (12, 16, 3), np.uint8)
BOX = np.array([(60.0, 80), (140, 80), (140, 140), (60, 140)])


def film(seconds: float, shift: float = 100.0, growth: float = 0.0) -> Film:
    """Ten pictures a second of a thing that moves to the right, in pixels a second, and grows."""
    for number in range(round(seconds * 10) + 1):
        t = number / 10
        picture = BACKGROUND.copy()
        scale = 1 + growth * t
        size = round(80 * scale), round(60 * scale)
        thing = cv2.resize(THING, size, interpolation=cv2.INTER_NEAREST)
        left = min(round(60 + shift * t), WIDTH)
        picture[80 : 80 + size[1], left : left + size[0]] = thing[:, : WIDTH - left]
        yield t, picture


def last(pictures: Film, *outlines: NDArray[np.float64]) -> list[Any]:
    *_, (_, found) = carry_on(pictures, [[outline] for outline in outlines])
    return found


def test_a_box_goes_with_its_thing_and_what_stands_still_stays() -> None:
    still = np.array([(400.0, 200), (500, 200), (500, 300), (400, 300)])
    moved, kept = last(film(3), BOX, still)
    assert moved[0] == pytest.approx(BOX + np.array((300, 0)), abs=4)
    assert kept[0] == pytest.approx(still, abs=1)


def test_a_box_grows_with_its_thing_and_stays_upright() -> None:
    ((polygon,),) = last(film(2, growth=0.25), BOX)
    assert np.ptp(polygon, axis=0) == pytest.approx([120, 90], rel=0.08)
    assert len(np.unique(polygon[:, 0])) == 2


def test_an_outline_of_many_corners_goes_along() -> None:
    outline = np.array([(65.0, 85), (100, 82), (135, 85), (135, 135), (65, 135)])
    ((polygon,),) = last(film(2), outline)
    assert polygon == pytest.approx(outline + np.array((200, 0)), abs=4)


def test_what_leaves_the_picture_is_lost() -> None:
    assert last(film(6.5), BOX) == [None]


def test_what_has_no_corners_stays_while_nothing_changes() -> None:
    plain = [(number / 10, np.full((HEIGHT, WIDTH, 3), 90, np.uint8)) for number in range(30)]
    ((polygon,),) = last(iter(plain), BOX)
    assert polygon == pytest.approx(BOX)


def test_moments_on_a_straight_way_are_left_out() -> None:
    times = np.arange(11.0)
    values = np.column_stack([times * 2, np.where(times < 5, 0, times - 5)])
    assert thinned(times, values, 0.1).tolist() == [0, 5, 10]
    assert thinned(times[:1], values[:1], 0.1).tolist() == [0]
