"""Which of several things alike is meant where words say no more than what kind it is.

"Next to the pallet" is at the one that is nearest to what goes there.
"""

from __future__ import annotations

import numpy as np

from g3.features.batch import FactorBatch
from g3.features.order import rivals
from g3.features.ranks import SAME_PLACE_M, is_robot, local_centres
from g3.groundings import FloatArray

FARTHER = float(np.log(0.1))
"""What it costs that a thing alike is nearer to the load."""


def near_scores(batch: FactorBatch, load: int) -> FloatArray:
    """What it costs each row's figure that another thing alike is nearer to the body ``load``."""
    labels = batch.bodies.labels
    alike = (labels[batch.peers] & labels[batch.figure][:, None]).any(axis=2)
    rival = rivals(batch) & alike & (batch.peers != load)
    middle = local_centres(batch, np.full(len(batch), load))
    own = np.linalg.norm(local_centres(batch, batch.figure) - middle, axis=-1)
    others = np.linalg.norm(local_centres(batch, batch.peers) - middle[:, None], axis=-1)
    farther = (rival & (others < own[:, None] - SAME_PLACE_M)).any(axis=1)
    farther &= (batch.bodies.count[batch.figure] == 1) & ~is_robot(batch)
    return np.where(farther, FARTHER, 0.0)
