"""The robot's body: a chassis that drives in the plane, a mast, and forks that go up it.

Its frame is on the ground between the front wheels, x ahead. Lengths are in metres.
"""

from __future__ import annotations

import mujoco

FORKS = "forks"
"""Body that goes up and down the mast, and its joint."""
DRIVE_JOINTS = ("drive-x", "drive-y", "drive-yaw")

CHASSIS = ((-1.2, 0.40), (-0.55, 0.55), (0.12, 2.1))
"""From and to, along x, y and z. The mast is in front of it, up to the heel of the forks."""
HEEL_X = 0.55
"""Where the forks begin; loads touch them there."""
FORK_LENGTH = 1.10
FORK_WIDTH = 0.12
FORK_THICKNESS = 0.04
FORK_Y = 0.23
"""The middles of the two tines are this far to the left and the right."""
LOW = 0.07
"""Height of the forks' upper side when they are down, above the ground."""
LIFT_RANGE = 2.0


def add_forklift(spec: mujoco.MjSpec, name: str) -> mujoco.MjsBody:
    """Add the robot without its looks; its joints' values are its pose.

    Returns
    -------
    mujoco.MjsBody
        The chassis, whose child :data:`FORKS` has the tines.
    """
    body = spec.worldbody.add_body(name=name)
    slide, hinge = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE
    for joint, kind, axis in zip(
        DRIVE_JOINTS,
        (slide, slide, hinge),
        ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
        strict=True,
    ):
        body.add_joint(name=joint, type=kind, axis=axis)
    _box(body, *CHASSIS, mass=1500.0)
    forks = body.add_body(name=FORKS, pos=[HEEL_X, 0, LOW])
    forks.add_joint(name=FORKS, type=slide, axis=[0, 0, 1], range=[0, LIFT_RANGE])
    for side in (-1, 1):
        y = side * FORK_Y
        _box(
            forks,
            (0.0, FORK_LENGTH),
            (y - FORK_WIDTH / 2, y + FORK_WIDTH / 2),
            (-FORK_THICKNESS, 0.0),
            mass=40.0,
        )
    return body


def _box(
    body: mujoco.MjsBody,
    x: tuple[float, float],
    y: tuple[float, float],
    z: tuple[float, float],
    mass: float,
) -> None:
    edges = (x, y, z)
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[(low + high) / 2 for low, high in edges],
        size=[(high - low) / 2 for low, high in edges],
        mass=mass,
        group=3,
    )
