"""The map lies as the picture does, for everybody who sees it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from annotation_app.items.scenes import Scene, map_turn
from tests.annotation_app.rendered import context


def scene(angle: float, *, seen: int = 4) -> Scene:
    """A picture from above, turned; it shows the first things."""
    world = context("hall", 0)
    outlines = []
    for thing in world.objects[:seen]:
        x, y = thing.prism.xy.mean(axis=0)
        along = 10 * (x * np.cos(angle) - y * np.sin(angle))
        up = 10 * (x * np.sin(angle) + y * np.cos(angle))
        outlines.append({"id": thing.id, "box": [along - 5, -up - 10, 10, 10], "polygons": [[]]})
    return Scene(world, 0.0, 1.0, (), {"objects": outlines})


@given(st.floats(-3.1, 3.1))
def test_the_map_is_turned_as_the_picture_is(angle: float) -> None:
    assert map_turn(scene(angle)) == pytest.approx(angle, abs=1e-6)


def test_a_map_without_a_picture_is_not_turned() -> None:
    assert map_turn(scene(1.0, seen=0)) == 0.0
    assert map_turn(scene(1.0, seen=1)) == 0.0
