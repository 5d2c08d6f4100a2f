"""A recording made by hand: the robot drives to a pallet, lifts it and turns, past a crate."""

from __future__ import annotations

import numpy as np

from corpus_tools.world.state.dimensions import LOW
from corpus_tools.world.state.recording import NS_PER_S, Recording, Step, upright
from g3.groundings import Context, PhysicalObject, Place, Prism, Trajectory

ROBOT, PALLET, CRATE, TRUCK = range(4)


def thing(name, labels, at, low, high):
    corners = np.array([low[:2], (high[0], low[1]), high[:2], (low[0], high[1])]) + at
    return PhysicalObject(
        name,
        labels,
        Prism(corners, low[2], high[2]),
        Trajectory(np.zeros(1), np.array([[*at, 0.0]]), np.zeros(1)),
    )


def scene() -> Context:
    objects = (
        thing("robot", ("forklift",), (0.0, 0.0), (-1.2, -0.6, 0.0), (0.55, 0.6, 2.1)),
        thing("load", ("box", "pallet"), (5.0, 0.0), (-0.5, -0.6, 0.0), (0.5, 0.6, 1.05)),
        thing("crate", ("crate",), (5.0, 3.0), (-0.5, -0.5, 0.0), (0.5, 0.5, 0.9)),
        thing("lorry", ("truck",), (10.0, -2.0), (-3.1, -1.1, 0.5), (3.1, 1.1, 1.0)),
    )
    place = Place(Prism(np.array([[2.0, -4], [4, -4], [4, -2], [2, -2]]), 0.0, 0.0), "receiving")
    return Context("by-hand", objects, (place,), "robot")


def drive(rate_hz: int = 10, still_s: float = 0.0) -> Recording:
    """Three seconds: one to the pallet, one to lift it, one to turn with it; then stillness."""
    context = scene()
    t_ns = np.arange(int((3 + still_s) * rate_hz) + 1, dtype=np.int64) * NS_PER_S // rate_hz
    t = t_ns / NS_PER_S
    n = len(t)
    position = np.tile([item.trajectory.xyz[0] for item in context.objects], (n, 1, 1))
    yaw = np.zeros((n, len(context.objects)))
    lift = np.clip(t - 1, 0, 1)
    yaw[:, ROBOT] = yaw[:, PALLET] = 0.8 * np.clip(t - 2, 0, 1)
    position[:, ROBOT, 0] = 3.4 * np.clip(t, 0, 1)
    held = t >= 1
    turn = yaw[held, ROBOT]
    position[held, PALLET, 0] = 3.4 + 1.6 * np.cos(turn)
    position[held, PALLET, 1] = 1.6 * np.sin(turn)
    position[held, PALLET, 2] = lift[held]
    steps = (Step("pick_up", (("object", "load"),), 0.0, 2.0),)
    return Recording(context, t_ns, position, upright(yaw), LOW + lift, steps)
