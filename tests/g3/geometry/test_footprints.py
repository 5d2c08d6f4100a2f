"""Footprints of single things."""

from __future__ import annotations

import numpy as np
import pytest

from g3.geometry.footprints import extent
from tests.worlds import prism


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.5])
def test_an_extent_is_along_across_and_up(yaw):
    box = prism(3.0, -4.0, (2.0, 0.5), (0.2, 1.7), yaw)
    assert extent(box, yaw) == pytest.approx([2.0, 0.5, 1.5])
    assert extent(box, yaw + np.pi / 2) == pytest.approx([0.5, 2.0, 1.5])
