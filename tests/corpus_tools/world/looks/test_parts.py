"""Surfaces face outwards, and are as large as asked for."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from corpus_tools.world.looks.atlas import PICTURE, colour, patch
from corpus_tools.world.looks.parts import (
    Part,
    ball,
    box,
    disc,
    extruded,
    join,
    moved,
    rod,
    tapered,
    turned,
)

GREY = colour("steel")


def volume(part: Part) -> float:
    """What a closed surface encloses; negative if its triangles face inwards."""
    a, b, c = np.moveaxis(part.at[part.face], 1, 0)
    return float((a * np.cross(b, c)).sum() / 6)


def faces_agree_with_normals(part: Part) -> bool:
    a, b, c = np.moveaxis(part.at[part.face], 1, 0)
    out = np.cross(b - a, c - a)
    return bool(((part.normal[part.face] * out[:, None]).sum(axis=2) > 0).all())


CLOSED = {
    "box": (box((0, 0, 0), (1, 2, 3), GREY), 6.0),
    "box of swapped corners": (box((1, 2, 3), (0, 0, 0), GREY), 6.0),
    # A frustum 3 high: 3 / 3 times the areas of its ends and the mean of 4 and 1.
    "tapered": (tapered((-1, -1, 0), (1, 1, 3), (-0.5, -0.5), (0.5, 0.5), GREY), 7.0),
    # A triangle of area 1/2, 4 long.
    "extruded": (extruded([(0, 0), (1, 0), (0, 1)], (-2, 2), GREY), 2.0),
    # A square of diagonal 2, 5 high.
    "turned": (turned([(0, 0), (1, 0), (1, 5), (0, 5)], GREY, segments=4), 10.0),
    "turned about x": (turned([(0, 0), (1, 0), (1, 5), (0, 5)], GREY, axis="x", segments=4), 10.0),
    "turned about y": (turned([(0, 0), (1, 0), (1, 5), (0, 5)], GREY, axis="y", segments=4), 10.0),
    "squashed": (
        turned([(0, 0), (1, 0), (1, 5), (0, 5)], GREY, segments=4, squash=0.5),
        5.0,
    ),
    # Two pyramids on a square of diagonal 2, each 1 high.
    "ball": (ball((0, 0, 0), (1, 1, 1), GREY, segments=4), 4 / 3),
    "rod with ends": (
        join(
            [
                rod((3, 0, 0), (3, 0, 5), 1.0, GREY, segments=4),
                disc((3, 0, 0), 1.0, GREY, facing="-z", segments=4),
                disc((3, 0, 5), 1.0, GREY, facing="+z", segments=4),
            ]
        ),
        10.0,
    ),
    "moved": (moved(box((0, 0, 0), (1, 2, 3), GREY), (5, 6, 7), 0.7), 6.0),
}


@pytest.mark.parametrize("name", CLOSED)
def test_closed_surfaces_enclose_what_they_should(name: str) -> None:
    part, expected = CLOSED[name]
    assert volume(part) == pytest.approx(expected)
    assert faces_agree_with_normals(part)
    assert np.linalg.norm(part.normal, axis=1) == pytest.approx(1)


def test_a_rod_leads_from_point_to_point() -> None:
    part = rod((1, 2, 3), (4, 6, 3), (0.2, 0.1), GREY)
    along = (part.at - (1, 2, 3)) @ np.array([0.6, 0.8, 0.0])
    assert along.min() == pytest.approx(0)
    assert along.max() == pytest.approx(5)
    assert faces_agree_with_normals(part)


def test_sides_that_nobody_sees_can_be_left_out() -> None:
    assert len(box((0, 0, 0), (1, 1, 1), GREY).face) == 12
    assert len(box((0, 0, 0), (1, 1, 1), GREY, without="-z +x").face) == 8


def test_a_disc_faces_along_its_axis() -> None:
    for facing, out in (("+x", (1, 0, 0)), ("-y", (0, -1, 0)), ("-z", (0, 0, -1))):
        part = disc((1, 2, 3), 0.5, GREY, facing=facing)
        assert faces_agree_with_normals(part)
        assert (part.normal == out).all()
        assert ((part.at - (1, 2, 3)) @ np.array(out)) == pytest.approx(0)


def seen(part: Part, corner: int) -> np.ndarray:
    """The atlas's colour at a corner of a part, shape (3,)."""
    atlas = cv2.imread(str(PICTURE))[..., ::-1]
    column, row = (part.uv[corner] * atlas.shape[0]).astype(int)
    return atlas[row, column].astype(int)


def test_plain_colours_are_darker_where_less_light_gets() -> None:
    side = box((0, 0, 0), (1, 1, 1), colour("white", 0.5))
    assert seen(side, 0) == pytest.approx([120, 120, 119], abs=5)
    assert seen(side, 2) == pytest.approx([240, 240, 238], abs=5)


def test_patches_lie_upright_on_sides() -> None:
    lower_left, _, upper_right, _ = box((0, 0, 0), (1, 1, 1), patch("grille")).uv[:4]
    assert (lower_left < upper_right).all()
    assert seen(box((0, 0, 0), (1, 1, 1), patch("grille")), 0).max() < 90  # the bumper
    assert seen(box((0, 0, 0), (1, 1, 1), patch("grille")), 2).max() > 180  # the bodywork
