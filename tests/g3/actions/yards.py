"""A yard with two pallets, a truck and a forklift, and what its actions would leave as logs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from g3.actions.action_kinds import Action, outcomes
from g3.actions.grounding_candidates import square
from g3.actions.logged_actions import Outcome
from g3.actions.robot_state import start_state
from g3.groundings import Context, PhysicalObject, Place, Trajectory
from tests.worlds import log, prism

Pose = tuple[float, float, float]


def box(
    id: str,
    labels: str,
    pose: Pose,
    size: tuple[float, float] = (1.2, 1.2),
    z: tuple[float, float] = (0.0, 0.7),
) -> PhysicalObject:
    x, y, yaw = pose
    way = log([(x, y)], yaw, sum(z) / 2, [100.0])
    return PhysicalObject(id, tuple(labels.split()), prism(x, y, size, z, yaw), way)


def forklift(pose: Pose = (0.0, 0.0, 0.0)) -> PhysicalObject:
    agent = box("agent", "forklift", pose, (1.5, 1.5), (0.0, 2.0))
    xyz = agent.trajectory.xyz * [1, 1, 0]
    return replace(agent, trajectory=Trajectory(agent.trajectory.t, xyz, agent.trajectory.yaw))


def spot(x: float, y: float, bottom: float = 0.0) -> Place:
    return square(np.array([x, y]), 0.0, bottom)


def yard(agent: Pose = (0.0, 0.0, 0.0), *more: PhysicalObject) -> Context:
    objects = (
        box("tires", "tire pallet", (10.0, 3.0, 0.3)),
        box("boxes", "box pallet", (10.0, -3.0, 0.0)),
        box("truck", "trailer", (-3.0, 14.0, 0.0), (6.0, 2.4), (0.4, 0.85)),
        *more,
        forklift(agent),
    )
    return Context("yard", objects, (spot(4.0, -9.0), spot(-4.0, 14.0, 0.85)), "agent")


def with_load(agent: Pose = (0.0, 0.0, 0.0)) -> Context:
    x, y, yaw = agent
    at = (x + 1.12 * np.cos(yaw), y + 1.12 * np.sin(yaw), yaw + 0.02)
    return yard(agent, box("load", "tire pallet", at, z=(0.3, 1.0)))


def thing(objects: Sequence[PhysicalObject], id: str) -> PhysicalObject:
    return next(o for o in objects if o.id == id)


def done(context: Context, action: Action) -> Outcome:
    return next(outcomes(start_state(context), [action]))


def logged(context: Context, action: Action) -> Context:
    """The context with the log that an action leaves."""
    made = done(context, action)
    return replace(context, objects=(*made.objects, made.agent))
