"""Constants of attentional vector sums."""

from __future__ import annotations

import numpy as np

SLOPE_PER_DEGREE = -0.006
INTERCEPT = 1.007
"""Acceptability falls linearly with the angular deviation; the values that Regier and Carlson
(2001) fitted."""

ATTENTION_WIDTH = 1.0
"""Lambda: how fast attention falls with distance, in units of the figure's distance."""

CORNER_INSET = 0.01
"""Distance of attention from a corner, as a part of the landmark's width. At the very end of a side
that runs along the direction, noise of its corners would choose between the two."""

NEAR = 0.03
"""Nearer to the focus than this, in units of the figure's distance, attention is as at this
distance: it is all but the same there, and single precision loses its differences."""

_NODES, _SHARES = np.array(np.polynomial.legendre.leggauss(3), dtype=np.float32)
PLACES, WEIGHTS = (_NODES + 1) / 2, _SHARES / 2
"""Places on each edge of the landmark at which the sum is evaluated, and their weights."""

PRECISION_DEG = 0.01
"""Directions are rounded to this."""
