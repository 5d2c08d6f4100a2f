from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from g3.features.sets.order import rivals
from g3.groundings import PhysicalObject
from g3.learning.examples import to_batch
from tests.g3.features.scenes import one, row, table
from tests.worlds import scene, thing

# The robot stands at the origin and looks along +x; +y is to its left.
LEFT = thing("left", "tire pallet", 8, 6)
MIDDLE = thing("middle", "box pallet", 8, 0)
RIGHT = thing("right", "tire pallet", 8, -6)
TRUCK = thing("truck", "trailer", 20, -9)
WORLD = scene(LEFT, MIDDLE, RIGHT, TRUCK)


def order(figure: PhysicalObject, words: str) -> dict[str, float]:
    return one("named-order", row(WORLD, "OBJECT", figure, words=words))


@pytest.mark.parametrize(
    ("words", "figure", "beaten"),
    [
        ("the leftmost pallet", LEFT, 1),
        ("the leftmost pallet", MIDDLE, 0.5),
        ("the leftmost pallet", RIGHT, 0),
        ("the pallet on the right", RIGHT, 1),
        # Among those of tires there are only two, and boxes are worse at being "tires".
        ("the left pallet of tires", LEFT, 1),
        ("the left pallet of tires", RIGHT, 0),
        ("the left pallet of tires", MIDDLE, 0.5),
        ("the nearest pallet", MIDDLE, 1),
        # The outer ones are equally far.
        ("the furthest pallet", LEFT, 0.75),
    ],
)
def test_what_words_name_among_what_they_could_mean(
    words: str, figure: PhysicalObject, beaten: float
) -> None:
    assert order(figure, words)["beaten"] == beaten


@pytest.mark.parametrize(
    ("words", "fits"),
    [
        ("the second pallet from the left", (0.5, 1, 0.5)),
        ("the third pallet from the left", (1 / 3, 0.5, 1)),
        ("the first pallet on the right", (0.5, 1, 1)),
    ],
)
def test_ordinals_count_from_a_side_or_from_the_robot(
    words: str, fits: tuple[float, float, float]
) -> None:
    found = [order(figure, words)["ordinal"] for figure in (LEFT, MIDDLE, RIGHT)]
    assert found == pytest.approx(fits)


def test_the_middle_has_as_many_on_either_side() -> None:
    assert [order(f, "the middle pallet")["middle"] for f in (LEFT, MIDDLE, RIGHT)] == [0, 1, 0]


def test_nothing_is_said_without_such_words_or_rivals() -> None:
    assert all(map(math.isnan, order(LEFT, "the pallet").values()))
    assert all(map(math.isnan, [order(TRUCK, "the left trailer")["beaten"]]))
    plural = one("named-order", row(WORLD, "OBJECT", (LEFT, RIGHT), words="the left pallets"))
    assert all(map(math.isnan, plural.values()))


def test_words_decide_on_the_rivals() -> None:
    batch = to_batch(
        [
            row(WORLD, "OBJECT", LEFT, words="the pallet"),
            row(WORLD, "OBJECT", LEFT, words="the tire pallet"),
            row(WORLD, "OBJECT", TRUCK, words="the lorry"),
        ]
    )
    assert rivals(batch).sum(axis=1).tolist() == [2, 1, 0]


@given(st.permutations([LEFT, MIDDLE, RIGHT, TRUCK]), st.sampled_from([LEFT, MIDDLE, RIGHT]))
def test_the_order_of_the_map_does_not_matter(
    things: list[PhysicalObject], figure: PhysicalObject
) -> None:
    words = "the second pallet from the left in the middle"
    shuffled = table("named-order", to_batch([row(scene(*things), "OBJECT", figure, words=words)]))
    assert {name: float(v[0]) for name, v in shuffled.items()} == order(figure, words)
