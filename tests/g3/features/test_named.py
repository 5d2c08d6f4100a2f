from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from g3.features.sets.named import named, satisfied
from g3.groundings import Path, PhysicalObject
from g3.language.lexicon.concepts import CONCEPTS
from g3.learning.examples import to_batch
from tests.g3.features.scenes import one, row
from tests.worlds import line, log, scene, thing

PALLET = thing("pallet", "tire pallet", 10, 0)
TRAILER = thing("trailer", "trailer", 20, 0, (6, 3))
LOAD = thing("load", "box pallet", 20, 0, z=(1, 2))
AT = {
    "left": thing("l", "tire pallet", 10, 6),
    "right": thing("r", "tire pallet", 10, -6),
    "front": thing("f", "tire pallet", 5, 0),
}
WORLD = scene(PALLET, TRAILER, LOAD, *AT.values())


def relation(figure: PhysicalObject, words: str, *landmarks: PhysicalObject) -> dict[str, float]:
    return one("named-relation", row(WORLD, "OBJECT", figure, landmark=landmarks, relation=words))


@pytest.mark.parametrize(
    ("words", "side"), [("to the left of", "left"), ("right of", "right"), ("in front of", "front")]
)
def test_the_side_that_the_relation_names(words: str, side: str) -> None:
    degrees = {place: relation(thing, words, PALLET)[side] for place, thing in AT.items()}
    assert degrees[side] == max(degrees.values()) == 1
    assert sorted(degrees.values())[-2] < 0.6


def test_only_what_the_words_name_counts() -> None:
    values = relation(AT["left"], "to the left of", PALLET)
    known = {column for column, value in values.items() if not np.isnan(value)}
    assert known == {"left", "mean", "least"}
    assert values["mean"] == values["least"] == 1
    assert np.isnan(list(relation(AT["left"], "with", PALLET).values())).all()


def test_on_is_supported() -> None:
    assert relation(LOAD, "on top of", TRAILER)["on"] == 1
    assert relation(PALLET, "on top of", TRAILER)["on"] == 0


def test_near_falls_off_with_the_gap() -> None:
    # Squares of 2 m: gaps of 4 m and 3 m, in sizes of 2 m.
    assert_allclose(relation(AT["left"], "near", PALLET)["near"], np.exp(-2))
    assert_allclose(relation(AT["front"], "near", PALLET)["near"], np.exp(-1.5))
    assert_allclose(relation(LOAD, "beside", TRAILER)["near"], 1)


def test_between_is_straight_between() -> None:
    assert_allclose(relation(PALLET, "between", AT["left"], AT["right"])["between"], 1)
    outside = relation(AT["front"], "between", PALLET, TRAILER)["between"]
    assert_allclose(outside, 0, atol=1e-9)


def test_mean_and_least_of_several_concepts() -> None:
    values = relation(AT["left"], "near left", PALLET)
    assert_allclose(values["mean"], (1 + np.exp(-2)) / 2)
    assert_allclose(values["least"], np.exp(-2))


def position(figure: PhysicalObject, words: str) -> dict[str, float]:
    return one("named-position", row(WORLD, "OBJECT", figure, words=words))


def test_the_position_that_the_figures_words_name() -> None:
    assert position(AT["left"], "the leftmost tire pallet")["left"] == 1
    assert position(AT["right"], "the pallet on the right")["right"] == 1
    assert position(AT["right"], "the leftmost tire pallet")["left"] < 0.5
    assert position(AT["front"], "the nearest pallet")["near"] == 1
    assert position(PALLET, "the nearest pallet")["near"] == 0
    assert position(AT["left"], "the furthest pallet")["far"] == 1


def test_a_relation_without_a_landmark_names_a_position() -> None:
    left = row(WORLD, "OBJECT", AT["left"], relation="on the left")
    assert one("named-position", left)["left"] == 1
    related = row(WORLD, "OBJECT", AT["left"], relation="on the left", landmark=(PALLET,))
    assert np.isnan(one("named-position", related)["left"])


def trajectory(path: Path, words: str) -> dict[str, float]:
    return one("named-shape", row(WORLD, "EVENT", path, relation=words))


def test_the_shape_that_the_relation_names() -> None:
    turned = np.linspace(0, np.pi / 2, 50)
    circle = 5 * np.column_stack((np.sin(turned), 1 - np.cos(turned)))
    left = Path(log(circle, yaw=turned))
    right = Path(log(circle * [1, -1], yaw=-turned))
    straight, back = Path(log(line((0, 0), (9, 0)))), Path(log(line((0, 0), (-9, 0))))
    # (2 / pi + tanh(pi / 2) + tanh(pi / 6)) / 3 leftward
    lead = (2 / np.pi + np.tanh(np.pi / 2) + np.tanh(np.pi / 6)) / 3
    assert_allclose(trajectory(left, "turn left")["left"], (1 + lead) / 2, atol=1e-3)
    assert_allclose(trajectory(right, "turn left")["left"], (1 - lead) / 2, atol=1e-3)
    assert_allclose(trajectory(straight, "turn left")["left"], 0.5)
    assert_allclose(trajectory(straight, "go forward")["front"], 1)
    assert_allclose(trajectory(back, "go forward")["front"], 0)
    assert_allclose(trajectory(back, "back up")["back"], 1)
    assert_allclose(trajectory(straight, "back up")["back"], 0)


def test_satisfied_skips_what_does_not_apply() -> None:
    wanted = np.zeros((3, len(CONCEPTS)), dtype=bool)
    column = [CONCEPTS.index(concept) for concept in ("left", "on", "near")]
    wanted[:, column] = [[True, True, True], [False, True, False], [False, False, True]]
    none = np.full(3, np.nan)
    degrees = {"left": np.full(3, 0.2), "on": np.full(3, 0.8), "near": none, "far": np.ones(3)}
    table = satisfied(degrees, wanted)
    assert_allclose(table[:, -2:], [[0.5, 0.2], [0.8, 0.8], [np.nan, np.nan]])
    assert_allclose(table[:, column], [[0.2, 0.8, np.nan], [np.nan, 0.8, np.nan], [np.nan] * 3])
    assert np.isnan(table[:, CONCEPTS.index("far")]).all()


def test_named_concepts_of_each_row() -> None:
    rows = [
        row(WORLD, "OBJECT", PALLET, relation="left", words="right"),
        row(WORLD, "OBJECT", PALLET, relation="the"),
    ]
    batch = to_batch(rows)
    assert_array_equal(
        [CONCEPTS[i] for i in np.flatnonzero(named(batch, ("relation",))[0])], ["left"]
    )
    both = named(batch, ("figure", "relation"))
    assert {CONCEPTS[i] for i in np.flatnonzero(both[0])} == {"left", "right"}
    assert not both[1].any()
