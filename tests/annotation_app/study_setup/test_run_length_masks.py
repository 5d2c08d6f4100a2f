"""Masks are read as COCO's own tools write them."""

from __future__ import annotations

import pytest

from annotation_app.study_setup.coco_things import Mask, outlines


@pytest.mark.parametrize(
    "counts",
    [
        [8, 2, 3, 2, 10],
        # The first three as they are, in six bits; then 2 - 2 and 10 - 3.
        "82307",
    ],
)
def test_a_square_of_two_pixels_worked_by_hand(counts: list[int] | str) -> None:
    # 5 rows and 5 columns, of which the rows 3 and 4 of the second and third column are inside.
    (square,) = outlines(Mask((5, 5), counts))
    assert sorted(square) == [[1, 3], [1, 4.5], [2.5, 3], [2.5, 4.5]]


def test_long_runs_take_several_letters_and_differences_may_be_below_zero() -> None:
    # 40 is 8 and once 32, 80 is 16 and twice 32; 40 - 80 = -40 is 24 less twice 32.
    # A run that ends with bit 16 would be below zero, so that 80 has a letter more.
    letters = "".join(chr(48 + bits) for bits in (8 + 32, 1, 16 + 32, 2, 8 + 32, 1, 24 + 32, 30))
    long = Mask((10, 20), [40, 80, 40, 40])
    assert outlines(Mask((10, 20), letters)) == outlines(long) != []


def test_an_empty_mask_has_no_outline_and_two_parts_have_two() -> None:
    assert outlines(Mask((3, 4), [12])) == []
    assert len(outlines(Mask((3, 4), [0, 1, 10, 1]))) == 2


@pytest.mark.parametrize("counts", [[11], [-1, 13], [13, -1], "\x00", "X", "é", [], [0, 1]])
def test_what_does_not_fill_the_picture_is_refused(counts: list[int] | str) -> None:
    with pytest.raises(ValueError, match="run-length"):
        outlines(Mask((3, 4), counts))
