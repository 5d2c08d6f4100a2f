from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from g3.groundings import PhysicalObject, Place
from tests.g3.features.scenes import one, row
from tests.worlds import line, log, prism, robot, scene, thing

LEFT, MIDDLE, RIGHT = (
    thing(name, "tire pallet", x, y)
    for name, x, y in (("left", 10, 4), ("middle", 12, 0), ("right", 16, -4))
)
OTHER = thing("other", "box pallet", 3, 9)
WORLD = scene(LEFT, MIDDLE, RIGHT, OTHER)


def ranks(figure: PhysicalObject) -> set[str]:
    values = one("ranks", row(WORLD, "OBJECT", figure))
    return {column for column, value in values.items() if value}


def test_three_pallets_in_a_row() -> None:
    # Distances are 10.8, 12 and 16.5 m; the box pallet is another kind of thing.
    assert ranks(LEFT) == {"ahead.first", "leftward.last", "far.first"}
    assert ranks(RIGHT) == {"ahead.last", "leftward.first", "far.last"}
    assert ranks(MIDDLE) == {
        f"{order}.{rank}"
        for order in ("ahead", "leftward", "far")
        for rank in ("second", "second_last", "middle")
    }


def test_a_thing_of_its_own_kind_has_no_rank() -> None:
    assert ranks(OTHER) == set()


def test_ranks_turn_with_the_agent() -> None:
    facing_back = scene(LEFT, MIDDLE, RIGHT, agent=robot(log([(0, 0)], yaw=np.pi)))
    values = one("ranks", row(facing_back, "OBJECT", LEFT))
    assert values["leftward.first"] == 1
    assert values["ahead.last"] == 1


def test_things_side_by_side_share_a_rank() -> None:
    a, b = thing("a", "pallet", 10, 4), thing("b", "pallet", 10.05, -4)
    values = one("ranks", row(scene(a, b), "OBJECT", a))
    assert not any(value for column, value in values.items() if column.startswith("ahead"))
    assert values["leftward.last"] == 1


@pytest.mark.parametrize(
    ("at", "ahead", "leftward"), [((9, 0), 1, 0), ((0, 7), 0, 1), ((-3, -4), -0.6, -0.8)]
)
def test_bearing_is_a_unit_vector(at: tuple[float, float], ahead: float, leftward: float) -> None:
    alone = thing("alone", "pallet", *at)
    values = one("bearing", row(scene(alone), "OBJECT", alone))
    assert_allclose([values["ahead"], values["leftward"]], [ahead, leftward], atol=1e-9)
    assert values["among_peers.leftward"] == 0


def test_bearing_among_peers_is_in_units_of_their_spread() -> None:
    things = [thing(str(y), "pallet", 10, y) for y in (-4, 0, 4)]
    spread = np.sqrt((16 + 0 + 16) / 3)
    for figure, expected in zip(things, (-4 / spread, 0, 4 / spread), strict=True):
        values = one("bearing", row(scene(*things), "OBJECT", figure))
        assert_allclose(values["among_peers.leftward"], expected, atol=1e-9)
        assert_allclose(values["among_peers.ahead"], 0, atol=1e-9)


def test_a_place_has_a_bearing_but_no_peers() -> None:
    values = one("bearing", row(WORLD, "PLACE", Place(prism(0, 5))))
    assert_allclose(values["leftward"], 1)
    assert np.isnan(values["among_peers.ahead"])


@pytest.mark.parametrize("name", ["ranks", "bearing", "named-position"])
def test_where_the_robot_is_seen_from_itself_is_nothing(name: str) -> None:
    own = WORLD.agent
    elsewhere = robot(log(line((40, 3), (50, 9)), yaw=0.5))
    for figure in (own, elsewhere):
        values = one(name, row(WORLD, "OBJECT", figure, words="the leftmost nearest forklift"))
        assert np.isnan(list(values.values())).all()
    seen = one(name, row(WORLD, "OBJECT", LEFT, words="the leftmost nearest pallet"))
    assert not np.isnan(list(seen.values())).all()
