"""The robot's body: a chassis that drives in the plane, a mast, and forks that go up it.

Its sizes are in :mod:`corpus_tools.world.state.dimensions`.
"""

from __future__ import annotations

import mujoco
import numpy as np

from corpus_tools.world.state import dimensions as sizes
from corpus_tools.world.state.solids import box

FORKS = "forks"
"""Body that goes up and down the mast, and its joint."""
DRIVE_JOINTS = ("drive-x", "drive-y", "drive-yaw")
ACTUATORS = (*DRIVE_JOINTS, FORKS)
"""Their order is that of the controls, which are where the joints shall be."""

CHASSIS_KG, CARRIAGE_KG, TINE_KG = 1500.0, 120.0, 40.0

DRIVE_RATE, TURN_RATE, LIFT_RATE = 16.0, 16.0, 30.0
"""Stiffness of the servos: angular frequencies in 1/s with the mass that they move."""
DRIVE_LIMIT_N, TURN_LIMIT_NM, LIFT_LIMIT_N = 12_000.0, 12_000.0, 25_000.0
_SERVOS = (
    (DRIVE_RATE, 2000.0, DRIVE_LIMIT_N),
    (DRIVE_RATE, 2000.0, DRIVE_LIMIT_N),
    (TURN_RATE, 1500.0, TURN_LIMIT_NM),
    (LIFT_RATE, 500.0, LIFT_LIMIT_N),
)


def add_forklift(spec: mujoco.MjSpec, name: str, ground_m: float = 0.0) -> mujoco.MjsBody:
    """Add the robot without its looks; its joints' values are its pose.

    Returns the chassis, whose child :data:`FORKS` has the tines.
    """
    body = spec.worldbody.add_body(name=name, pos=[0, 0, ground_m])
    slide, hinge = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE
    for joint, kind, axis in zip(DRIVE_JOINTS, (slide, slide, hinge), np.eye(3), strict=True):
        body.add_joint(name=joint, type=kind, axis=axis)
    box(body, sizes.CHASSIS, mass=CHASSIS_KG)
    box(body, sizes.MAST, mass=0.0)
    forks = body.add_body(name=FORKS, pos=[sizes.HEEL_X, 0, sizes.LOW], gravcomp=1)
    forks.add_joint(name=FORKS, type=slide, axis=[0, 0, 1], range=[0, sizes.LIFT_RANGE])
    box(forks, sizes.BACKREST, mass=CARRIAGE_KG)
    for side in (-1, 1):
        box(forks, _tine(side * sizes.FORK_Y), mass=TINE_KG)
    for joint, (rate, moved, limit) in zip(ACTUATORS, _SERVOS, strict=True):
        _add_servo(spec, joint, rate, moved, limit)
    return body


def _tine(y: float) -> sizes.Extent:
    return (
        (0.0, sizes.FORK_LENGTH),
        (y - sizes.FORK_WIDTH / 2, y + sizes.FORK_WIDTH / 2),
        (-sizes.FORK_THICKNESS, 0.0),
    )


def _add_servo(spec: mujoco.MjSpec, joint: str, rate: float, moved: float, limit: float) -> None:
    """Add a critically damped servo to a position."""
    stiffness, damping = moved * rate**2, 2 * moved * rate
    servo = spec.add_actuator(
        name=joint,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        target=joint,
        forcerange=[-limit, limit],
        forcelimited=True,
    )
    servo.set_to_position(kp=stiffness, kv=damping)
