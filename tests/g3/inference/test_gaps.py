"""What isn't covered yet, each by its name: a gap that closes fails here, and goes.

The table in docs/wordings.md lists the same names.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from g3.actions.grounding_candidates import spots_about
from g3.actions.robot_state import start_state
from g3.geometry.footprints import centre
from g3.groundings import FloatArray, PhysicalObject
from g3.inference.problem.asked_spots import spots_asked
from g3.inference.problem.command_tree import Tree
from g3.sdc.sdc_notation import parse_brackets
from tests.g3.actions.yards import box, forklift
from tests.worlds import scene

TRAILER = box("trailer", "trailer", (0, 0, 0), (6.0, 3.0), (0.4, 0.85))
CRATE = box("crate", "crate", (0, 0, 0))


def spots(*group: PhysicalObject, others: tuple[PhysicalObject, ...] = ()) -> FloatArray:
    """Candidates of places about things, x, y, z (n, 3), for a robot 20 m away."""
    state = start_state(scene(*group, *others, agent=forklift((20.0, 0.0, 0.0))))
    found = [spot.prism for spot in spots_about(group, state)]
    return np.array([[*centre(prism), prism.z_min] for prism in found])


def has(found: FloatArray, *place: float, within: float = 0.7) -> bool:
    return bool((np.linalg.norm(found - np.array(place), axis=1) < within).any())


def diagonal_on_a_deck() -> bool:
    """Beside a load in the middle of a wide deck, neither along nor across it."""
    load = box("load", "crate", (0, 0, 0), z=(0.85, 1.55))
    return has(spots(load, others=(TRAILER,)), 1.5, 0.85, 0.85)


def on_a_load() -> bool:
    """On a crate; "on top of a crate" and stacking are covered."""
    asked = spots_asked(Tree(parse_brackets("PLACE(r = on, l = OBJ(f = the crate))")), 0)
    state = start_state(scene(CRATE, agent=forklift((20.0, 0.0, 0.0))))
    return any(spot.prism.z_min > 0.5 for spot in spots_about((CRATE,), state, asked))


GAPS: dict[str, Callable[[], bool]] = {
    "on a load": on_a_load,
    "diagonal on a deck": diagonal_on_a_deck,
}


@pytest.mark.parametrize(
    "name", [pytest.param(gap, marks=pytest.mark.xfail(strict=True, reason=gap)) for gap in GAPS]
)
def test_what_is_not_a_candidate(name):
    assert GAPS[name]()
