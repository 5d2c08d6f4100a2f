from __future__ import annotations

import numpy as np
import pytest

from corpus_tools.video.drawing.shadows import NOTHING, ShadowMap, shade

TEXEL_M = 0.01


@pytest.mark.parametrize(("lamp_m", "wide_m"), [(0.0, 0.03), (0.15, 0.3)])
def test_the_edge_of_a_shadow_is_as_wide_as_the_lamp(lamp_m, wide_m):
    depth = np.full((200, 200), NOTHING, np.float32)
    depth[:, :100] = 1.0  # a thing over half of the map, a metre down the light
    across = np.linspace(0.5, 1.5, 200, dtype=np.float32)
    place = np.stack((np.tile(across, (50, 1)), np.ones((50, 200)), np.full((50, 200), 3.0)))
    place = place.astype(np.float32)
    (sun,) = shade(ShadowMap((0, 0), TEXEL_M, depth), place, 0.02, 1, lamp_m)[25:26].astype(int)
    assert (sun[0], sun[-1]) == (0, 255)
    assert (np.diff(sun) >= 0).all()
    edge = across[(sun > 0) & (sun < 255)]
    assert (float(np.ptp(edge)) if len(edge) else 0.0) <= wide_m
    assert len(np.unique(sun)) >= (5 if lamp_m else 2)
