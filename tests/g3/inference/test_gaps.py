"""What isn't covered yet, each by its name: a gap that closes fails here, and goes.

The table in docs/inference.md lists the same names.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from g3.actions.grounding_candidates import object_groups, spots_about
from g3.actions.robot_state import start_state
from g3.geometry.footprints import centre
from g3.groundings import FloatArray, PhysicalObject
from g3.inference.potentials.cases import SpotCase
from g3.inference.potentials.potential_registry import allowed
from tests.g3.actions.yards import box, forklift
from tests.g3.inference.ruled import problem_in
from tests.worlds import scene

DOCS = Path(__file__).parents[3] / "docs" / "inference.md"
TRAILER = box("trailer", "trailer", (0, 0, 0), (6.0, 3.0), (0.4, 0.85))
CRATE = box("crate", "crate", (0, 0, 0))


def spots(*group: PhysicalObject, others: tuple[PhysicalObject, ...] = ()) -> FloatArray:
    """Candidates of places about things, x, y, z (n, 3), for a robot 20 m away."""
    state = start_state(scene(*group, *others, agent=forklift((20.0, 0.0, 0.0))))
    found = [spot.prism for spot in spots_about(group, state)]
    return np.array([[*centre(prism), prism.z_min] for prism in found])


def has(found: FloatArray, *place: float, within: float = 0.7) -> bool:
    return bool((np.linalg.norm(found - np.array(place), axis=1) < within).any())


def crates(count: int) -> list[PhysicalObject]:
    return [box(f"c{i}", "crate", (3.0 * i, 0, 0)) for i in range(count)]


def part_of_a_row() -> bool:
    """The three leftmost crates of six."""
    groups = object_groups(scene(*crates(6), agent=forklift((8, -9, 0))))
    return {"c0", "c1", "c2"} in [{getattr(o, "id", "") for o in group} for group in groups]


def top_of_a_load() -> bool:
    return has(spots(CRATE), 0, 0, 0.7)


def corner_of_a_thing() -> bool:
    """The ground beside a trailer's front left corner."""
    return has(spots(TRAILER), 3.0, 3.1, 0)


def diagonal_on_a_deck() -> bool:
    """Beside a load in the middle of a wide deck, neither along nor across it."""
    load = box("load", "crate", (0, 0, 0), z=(0.85, 1.55))
    return has(spots(load, others=(TRAILER,)), 1.5, 0.85, 0.85)


def side_of_a_narrow_deck() -> bool:
    """The left of a deck that has room for one load across, and a bit."""
    narrow = box("trailer", "trailer", (0, 0, 0), (6.0, 2.0), (0.4, 0.85))
    return has(spots(narrow), 0, 0.4, 0.85, within=0.2)


def so_far_away() -> bool:
    """Five metres to the left of the crate."""
    return has(spots(CRATE), 0, 5.6, 0)


def where_the_robot_stands() -> bool:
    """Left of the crate, where the robot will have left for the load by then."""
    load = box("load", "tire pallet", (12.0, 0, 0))
    problem = problem_in(scene(CRATE, load, agent=forklift((0, 2.2, 0))), load="load")
    about = spots_about((CRATE,), problem.state)
    free = [s for s, ok in zip(about, allowed(SpotCase(problem, about)), strict=True) if ok]
    return has(np.array([[*centre(s.prism), s.prism.z_min] for s in free]), 0, 2.2, 0)


def bend_in_a_row() -> bool:
    """A row that turns a corner."""
    corner = [*crates(4), *(box(f"d{i}", "crate", (9.0, 3.0 * i, 0)) for i in range(1, 4))]
    far = [box(f"f{i}", "crate", (60.0 + 9 * i, 40, 0)) for i in range(2)]
    state = problem_in(scene(*corner, *far, agent=forklift((-8, -9, 0))))
    return frozenset(o.id for o in corner) in state.rows


GAPS: dict[str, Callable[[], bool]] = {
    "part of a row": part_of_a_row,
    "top of a load": top_of_a_load,
    "corner of a thing": corner_of_a_thing,
    "diagonal on a deck": diagonal_on_a_deck,
    "side of a narrow deck": side_of_a_narrow_deck,
    "so far away": so_far_away,
    "where the robot stands": where_the_robot_stands,
    "bend in a row": bend_in_a_row,
}


@pytest.mark.parametrize(
    "name", [pytest.param(gap, marks=pytest.mark.xfail(strict=True, reason=gap)) for gap in GAPS]
)
def test_what_is_not_a_candidate(name):
    assert GAPS[name]()


def test_each_gap_is_in_the_documentation():
    table = [line for line in DOCS.read_text().splitlines() if line.startswith("| *")]
    assert [line.split("*")[1] for line in table] == list(GAPS)
