"""Models of contexts: whatever the objects are called, each is found where it is."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from corpus_tools.world.physics.build import body_name, build_world, set_state
from corpus_tools.world.state.recording import Recording, upright
from g3.groundings import Context
from tests.worlds import thing


def box(name, labels, x):
    return thing(name, labels, x, 0, (1, 1), (0.0, 0.7))


@pytest.mark.parametrize("name", ["forks", "world", "floor", "drive-x", "object forks", "sun", ""])
def test_objects_may_have_the_names_of_what_the_world_has(name):
    objects = (box("robot", "forklift", 0), box(name, "box pallet", 4))
    start = Context("yard", objects, (), "robot")
    world = build_world(start)
    position = np.array([[[0.0, 0, 0], [4.0, 1, 2]]])
    recording = Recording(
        start, np.zeros(1, np.int64), position, upright(np.zeros((1, 2))), np.array([0.5])
    )
    data = mujoco.MjData(world.model)
    set_state(world, data, recording, 0)
    assert data.body(body_name(name)).xpos.tolist() == [4.0, 1.0, 2.0]
    assert data.body(body_name("robot")).xpos.tolist() == [0.0, 0.0, 0.0]
    assert data.body("forks").xpos[2] == pytest.approx(0.5)
