from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from g3.groundings import Path, PhysicalObject, Place
from tests.g3.features.scenes import one, row
from tests.worlds import line, log, prism, scene, thing

TRAILER = thing("trailer", "trailer", 10, 0, (6, 3), (0, 1))
LOAD = thing("load", "tire pallet", 10, 0, (2, 2), (1, 2))
ASIDE = thing("aside", "tire pallet", 10, 4.5, (2, 2), (0, 1))
WORLD = scene(TRAILER, LOAD, ASIDE)


def pair(figure: PhysicalObject, landmark: PhysicalObject) -> dict[str, float]:
    return one("prism-pair", row(WORLD, "OBJECT", figure, landmark=(landmark,)))


def test_a_pallet_on_a_trailer() -> None:
    values = pair(LOAD, TRAILER)
    assert [values[c] for c in ("supports", "contact", "inside", "gap", "distance")] == [
        1, 1, 1, 0, 0,
    ]  # fmt: skip
    assert_allclose(values["figure_overlap"], 1)
    assert_allclose(values["landmark_overlap"], 4 / 18)
    assert_allclose(values["height_above"], 0)
    assert_allclose(values["height_difference"], 1)
    assert_allclose(values["size_ratio"], np.log10(4 / 18))


def test_a_trailer_is_not_supported_by_its_load() -> None:
    values = pair(TRAILER, LOAD)
    assert values["supports"] == 0
    assert_allclose(values["figure_overlap"], 4 / 18)
    assert_allclose(values["height_above"], -2)


def test_a_pallet_two_metres_beside_a_trailer() -> None:
    values = pair(ASIDE, TRAILER)
    scale = (2 + np.sqrt(18)) / 2
    assert [values[c] for c in ("supports", "contact", "inside", "figure_overlap")] == [0] * 4
    assert_allclose(values["gap"], 2 / scale)
    assert_allclose(values["distance"], 4.5 / scale)
    assert_allclose(values["height_above"], -1)
    assert_allclose(values["height_difference"], 0)


def test_things_that_touch_are_in_contact_unless_one_is_high_above() -> None:
    beside = thing("beside", "pallet", 14, 0, (2, 2), (0, 1))
    above = thing("above", "pallet", 14, 0, (2, 2), (3, 4))
    assert pair(beside, TRAILER)["contact"] == 1
    assert pair(above, TRAILER)["contact"] == 0


def test_near_is_nearer_than_far() -> None:
    near, far = (thing("it", "pallet", x, 0) for x in (15, 25))
    for column in ("gap", "distance"):
        assert pair(near, TRAILER)[column] < pair(far, TRAILER)[column]


def test_nothing_depends_on_the_scale() -> None:
    small, large = (
        one(
            "prism-pair",
            row(
                WORLD,
                "OBJECT",
                thing("a", "pallet", 0, 5 * k, (2 * k, k), (0, k)),
                landmark=(thing("b", "pallet", 0, 0, (3 * k, k), (0, 2 * k)),),
            ),
        )
        for k in (1, 3)
    )
    assert small == pytest.approx(large)


def test_sets_of_two_arguments_say_nothing_without_a_landmark() -> None:
    for name in ("prism-pair", "avs-start", "avs-speaker", "between"):
        assert np.isnan(list(one(name, row(WORLD, "OBJECT", LOAD)).values())).all()
    event = row(WORLD, "EVENT", LOAD, landmark=(TRAILER,))
    assert np.isnan(list(one("prism-pair", event).values())).all()


@pytest.mark.parametrize(
    ("landmarks", "straight", "even"),
    [
        ([(5, 3), (5, -3)], 1, 1),
        ([(5, 3), (5, -6)], 1, 0.5),
        ([(5, 3), (8, 0)], 0, 1),
        ([(5, 3), (5, 6)], -1, 0.5),
        ([(5, 3), (5, 6), (5, -6)], 1, 0.5),
    ],
)
def test_between_two_things(
    landmarks: list[tuple[float, float]], straight: float, even: float
) -> None:
    middle = thing("middle", "pallet", 5, 0)
    around = tuple(thing(str(i), "pallet", x, y) for i, (x, y) in enumerate(landmarks))
    values = one("between", row(scene(*around), "OBJECT", middle, landmark=around))
    assert_allclose(list(values.values()), [straight, even], atol=1e-9)


def test_nothing_is_between_one_thing() -> None:
    values = one("between", row(WORLD, "OBJECT", LOAD, landmark=(TRAILER,)))
    assert np.isnan(list(values.values())).all()


def test_arguments_says_what_there_is() -> None:
    many = row(WORLD, "OBJECT", (LOAD, ASIDE), landmark=(TRAILER,))
    assert one("arguments", many) == {
        "several": 1, "landmark": 1, "landmark_several": 0, "theme": 0, "goal": 0,
    }  # fmt: skip
    event = row(WORLD, "EVENT", LOAD, theme=(LOAD,), goal=(TRAILER,))
    assert one("arguments", event) == {
        "several": 0, "landmark": 0, "landmark_several": 0, "theme": 1, "goal": 1,
    }  # fmt: skip
    landmarks = row(WORLD, "PLACE", Place(prism(0, 0)), landmark=(LOAD, ASIDE))
    assert one("arguments", landmarks)["landmark_several"] == 1


@pytest.mark.parametrize(
    ("place", "expected"),
    [
        # on the floor 4 m from the trailer and further from the rest: gaps are 4 / 3.12
        (prism(4, -4.5, z=(0, 1)), {"on_ground": 1, "supported": 0, "occupied": 0}),
        (prism(11, 0, z=(1, 2)), {"on_ground": 0, "supported": 1, "occupied": 1}),
        (prism(8, 0, (1, 1), z=(1, 2)), {"on_ground": 0, "supported": 1, "occupied": 0}),
        (prism(10, 4.5), {"on_ground": 1, "supported": 0, "occupied": 1, "nearest_gap": 0}),
    ],
)
def test_places_in_a_scene(place: object, expected: dict[str, float]) -> None:
    values = one("scene", row(WORLD, "PLACE", Place(place)))
    assert {column: values[column] for column in expected} == pytest.approx(expected)


def test_things_near_a_place_are_counted() -> None:
    far = row(WORLD, "PLACE", Place(prism(-40, 0)))
    assert one("scene", far)["near_count"] == 0
    assert one("scene", far)["nearest_gap"] == 9
    # The trailer and the pallet on it lie within a size of it; the one aside does not.
    near = row(WORLD, "PLACE", Place(prism(10, -3)))
    assert one("scene", near)["near_count"] == 2


def test_a_scene_without_things_has_free_places() -> None:
    values = one("scene", row(scene(), "PLACE", Place(prism(3, 0))))
    assert values == {
        "on_ground": 1, "supported": 0, "occupied": 0, "nearest_gap": 9, "near_count": 0,
    }  # fmt: skip


def test_a_path_is_the_box_around_it_along_its_heading() -> None:
    # 8 m along a heading of 30 degrees: a segment, whose middle is the path's middle.
    heading = np.radians(30)
    end = 8 * np.array([np.cos(heading), np.sin(heading)])
    path = Path(log(line((0, 0), end), yaw=heading))
    near = thing("near", "pallet", *(end / 2))
    values = one("prism-pair", row(WORLD, "PLACE", path, landmark=(near,)))
    assert_allclose([values["gap"], values["distance"]], [0, 0], atol=1e-9)
