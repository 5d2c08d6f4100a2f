from __future__ import annotations

import numpy as np
import pytest

from corpus_tools.world.state.recording import NS_PER_S, Recording, Step, upright
from g3.groundings import Context, PhysicalObject, Place, Prism, Trajectory


def block(name, labels, x, z=0.0):
    xy = np.array([[x - 0.5, -0.6], [x + 0.5, -0.6], [x + 0.5, 0.6], [x - 0.5, 0.6]])
    return PhysicalObject(
        name, labels, Prism(xy, z, z + 0.7), Trajectory([0.0], [[x, 0.0, z]], [0.0])
    )


@pytest.fixture
def driving():
    """Over 2 s at 2 Hz the robot backs by 0.5 m a moment, with a pallet from 1 s on."""
    start = Context(
        "yard",
        (block("robot", ("forklift",), 0.0), block("tires", ("tire", "pallet"), 1.1)),
        (Place(Prism([[0, 0], [4, 0], [4, 4]], 0.0, 1.0), "receiving"),),
        "robot",
    )
    position = np.zeros((5, 2, 3))
    position[:, 0, 0] = [0.0, 0.0, 0.0, -0.5, -1.0]
    position[:, 1, 0] = [1.1, 1.1, 1.1, 0.6, 0.1]
    position[2:, 1, 2] = 0.3
    return Recording(
        start,
        np.arange(5) * (NS_PER_S // 2),
        position,
        upright(np.zeros((5, 2))),
        np.array([0.07, 0.07, 0.41, 0.41, 0.41]),
        (Step("pick_up", (("object", "tires"),), 0.5, 2.0),),
    )
