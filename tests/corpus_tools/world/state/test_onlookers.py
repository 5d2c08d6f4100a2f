from __future__ import annotations

import mujoco
import numpy as np
import pytest

from corpus_tools.logs.log_reading import read_log
from corpus_tools.logs.log_writing import to_bytes
from corpus_tools.world.physics.build import build_world, set_state
from corpus_tools.world.state.onlookers import ASIDE_M, LOOK_M, with_onlookers
from corpus_tools.world.state.recording import NS_PER_S, Recording, heading, to_context, upright
from g3.actions.logged_actions import moved
from g3.groundings import Context
from tests.corpus_tools.video.recordings import thing

SIZE = (-0.25, -0.25, 0.0), (0.25, 0.25, 1.75)
RATE_HZ, SECONDS = 10, 12


def passing(*people, others=(), to_x=12.0):
    """Return a recording of a robot that drives along x past people at places x, y."""
    robot = thing("robot", ("forklift",), (0.0, 0.0), (-1.2, -0.6, 0.0), (0.55, 0.6, 2.1))
    persons = [thing(f"p{n}", ("person",), at, *SIZE) for n, at in enumerate(people)]
    objects = (robot, *persons, *others)
    t_ns = np.arange(SECONDS * RATE_HZ + 1, dtype=np.int64) * NS_PER_S // RATE_HZ
    position = np.tile([item.trajectory.xyz[0] for item in objects], (len(t_ns), 1, 1))
    position[:, 0, 0] = np.linspace(0, to_x, len(t_ns))
    yaw = np.zeros(position.shape[:2])
    return Recording(
        Context("here", objects, (), "robot"), t_ns, position, upright(yaw), np.zeros(len(t_ns))
    )


def test_people_look_at_the_robot():
    recording = with_onlookers(passing((6.0, 5.0)))
    ways = recording.position[:, 0, :2] - recording.position[:, 1, :2]
    wanted = np.arctan2(ways[:, 1], ways[:, 0])
    off = np.angle(np.exp(1j * (heading(recording.orientation[:, 1]) - wanted)))
    assert np.abs(off[40:]).max() < 0.5
    assert heading(recording.orientation[0, 1]) == 0.0


def test_nobody_looks_at_a_robot_far_away():
    far = passing((0.0, LOOK_M + 1))
    assert (with_onlookers(far).orientation == far.orientation).all()


@pytest.mark.parametrize("side", [1.5, -1.5])
def test_people_step_out_of_the_way_and_come_back(side):
    recording = passing((6.0, side))
    seen = with_onlookers(recording)
    aside = (seen.position[:, 1, 1] - side) * np.sign(side)
    assert aside.max() == pytest.approx(ASIDE_M)
    assert aside.min() == 0.0
    speed = np.linalg.norm(np.diff(seen.position[:, 1], axis=0), axis=1) * RATE_HZ
    assert speed.max() < 0.8
    assert (seen.position[[0, -1], 1] == recording.position[[0, -1], 1]).all()
    assert "p0" not in moved(to_context(seen))


def test_nobody_steps_into_a_thing():
    shelf = thing("shelf", ("shelf",), (6.0, 2.5), (-2.0, -0.5, 0.0), (2.0, 0.5, 2.0))
    recording = passing((6.0, 1.5), others=[shelf])
    assert (with_onlookers(recording).position == recording.position).all()


def test_all_else_stays_and_the_log_has_what_is_seen(tmp_path):
    crate = thing("crate", ("crate",), (9.0, -4.0), (-0.5, -0.5, 0.0), (0.5, 0.5, 0.9))
    recording = passing((6.0, 1.5), others=[crate])
    seen = with_onlookers(recording)
    for index in (0, 2):
        assert (seen.position[:, index] == recording.position[:, index]).all()
        assert (seen.orientation[:, index] == recording.orientation[:, index]).all()
    log = tmp_path / "log.mcap"
    log.write_bytes(to_bytes(seen, name="here", metadata={}))
    assert np.allclose(read_log(log).recording.position[:, 1], seen.position[:, 1])


def test_people_walk_on_their_legs_where_the_way_leads():
    seen = with_onlookers(passing((6.0, 1.5)))
    world = build_world(seen.start)
    data = mujoco.MjData(world.model)
    swings = []
    for k in range(len(seen.t_ns)):
        set_state(world, data, seen, k)
        swings.append(data.qpos[world.legs_qpos[0]].copy())
    angles = np.array(swings)
    step = np.gradient(seen.position[:, 1], seen.t_s, axis=0)
    speed = np.linalg.norm(step, axis=1)
    assert (angles[:, 0] == -angles[:, 1]).all()
    assert np.abs(angles[speed > 0.4]).max() > 0.3
    assert np.abs(angles[speed == 0]).max() == 0
    fast = speed > 0.5
    way = np.arctan2(step[fast, 1], step[fast, 0])
    off = np.angle(np.exp(1j * (heading(seen.orientation[fast, 1]) - way)))
    assert np.abs(off).min() < 0.5
