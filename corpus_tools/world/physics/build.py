"""A MuJoCo model of a world, for physics and for pictures."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from corpus_tools.world.looks.look_registry import look_of
from corpus_tools.world.looks.people import LEGS
from corpus_tools.world.looks.site_looks import add_surroundings
from corpus_tools.world.state.dimensions import LOW
from corpus_tools.world.state.forklift_parts import DRIVE_JOINTS, FORKS, add_forklift
from corpus_tools.world.state.recording import Recording, heading, upright
from corpus_tools.world.state.shapes import shape_of
from corpus_tools.world.state.solids import FRICTION, SOLID_GROUP, add_solid
from corpus_tools.world.state.thing_kinds import FORKLIFT, kind_of
from g3.groundings import Context, FloatArray
from g3.short_repr import short_repr

Index = npt.NDArray[np.int64]

FLOOR = "floor"
"""Geom of the ground."""
TIMESTEP_S = 0.005
IMPRATIO = 10.0
"""Ratio of the stiffness of friction to that of the normal force: loads on the forks must not
creep."""
STRIDE_M, SWING_RAD, STRIDING = 0.6, 0.4, 0.4
"""Length of two steps, how far legs swing, and the speed in m/s from which they do so fully."""


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class World:
    """A compiled model of a context, and the positions of its objects in the simulator's state."""

    context: Context
    """The context; the objects' order is that of all indices."""
    model: mujoco.MjModel
    free: Index
    free_qpos: Index
    """Objects with a free joint, and the first positions of their seven coordinates."""
    mocap: Index
    mocap_id: Index
    """Objects that only move where they are put, and their mocap indices."""
    robot: int
    """Index of the robot among the objects."""
    drive_qpos: Index
    forks_qpos: int
    """Positions of the robot's x, y, yaw and of its forks' height in the simulator's state."""
    walkers: Index
    legs_qpos: Index
    """People whose legs are seen, and the positions of the angles of both."""


def build_spec(
    context: Context, *, looks: bool = True, site: str = "yard", names: bool = False
) -> mujoco.MjSpec:
    """Build a world with the objects of a context.

    Objects' bodies are called by :func:`body_name` and have their poses as frames. What the forks
    can lift has a free joint. The robot has joints to drive in the plane. Everything else is a
    mocap body, which collides and moves only where it is put. `looks` adds what is only there to be
    seen, `site` what it looks like around the objects (one of
    :data:`~corpus_tools.world.looks.site_looks.SITES`), `names` the names of places, painted on the
    ground.
    """
    spec = mujoco.MjSpec()
    spec.option.timestep = TIMESTEP_S
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = IMPRATIO
    ground = ground_of(context)
    _add_floor(spec, ground)
    for item in context.objects:
        kind = kind_of(item.labels)
        pose = item.trajectory
        if item.id == context.agent_id:
            kind = FORKLIFT
            body = add_forklift(spec, body_name(item.id), ground)
        else:
            body = spec.worldbody.add_body(
                name=body_name(item.id),
                pos=pose.xyz[0],
                quat=upright(pose.yaw[0]),
                mocap=not kind.carriable,
            )
            if kind.carriable:
                body.add_freejoint()
            add_solid(body, kind, shape_of(item), ground - pose.xyz[0, 2])
        if looks:
            look_of(kind.name)(spec, body, shape_of(item), ground - pose.xyz[0, 2])
            if item.colours:
                from corpus_tools.world.looks.painting import paint  # noqa: PLC0415 - OpenCV

                paint(spec, body, item.colours[0])
    if looks:
        add_surroundings(spec, context, ground, site)
        if names:
            from corpus_tools.world.looks.painting import add_names  # noqa: PLC0415 - OpenCV

            add_names(spec, context, ground)
    return spec


def build_world(
    context: Context, *, looks: bool = True, site: str = "yard", names: bool = False
) -> World:
    """Compile :func:`build_spec`."""
    model = build_spec(context, looks=looks, site=site, names=names).compile()
    ids = [item.id for item in context.objects]
    body = [model.body(body_name(name)) for name in ids]
    robot = ids.index(context.agent_id)
    mocap = [i for i in range(len(ids)) if body[i].mocapid[0] >= 0]
    free = [i for i in range(len(ids)) if i != robot and i not in mocap]
    joints = {model.joint(i).name: i for i in range(model.njnt)}
    legs = [[joints.get(f"{body_name(name)} {leg}", -1) for leg in LEGS] for name in ids]
    walkers = [i for i in mocap if min(legs[i]) >= 0]
    return World(
        context,
        model,
        free=np.array(free, dtype=np.int64),
        free_qpos=_qpos(model, [body[i].jntadr[0] for i in free]),
        mocap=np.array(mocap, dtype=np.int64),
        mocap_id=np.array([body[i].mocapid[0] for i in mocap], dtype=np.int64),
        robot=robot,
        drive_qpos=_qpos(model, [model.joint(name).id for name in DRIVE_JOINTS]),
        forks_qpos=int(model.joint(FORKS).qposadr[0]),
        walkers=np.array(walkers, dtype=np.int64),
        legs_qpos=_qpos(model, [joint for i in walkers for joint in legs[i]]).reshape(-1, 2),
    )


def set_state(world: World, data: mujoco.MjData, recording: Recording, k: int) -> None:
    """Put everything where it was at the k-th moment of a recording, without physics."""
    position, orientation = recording.position[k], recording.orientation[k]
    poses = np.concatenate((position, orientation), axis=1)
    if len(world.free):
        data.qpos[world.free_qpos[:, None] + np.arange(7)] = poses[world.free]
    data.mocap_pos[world.mocap_id] = position[world.mocap]
    data.mocap_quat[world.mocap_id] = orientation[world.mocap]
    data.qpos[world.drive_qpos[:2]] = position[world.robot, :2]
    data.qpos[world.drive_qpos[2]] = heading(orientation[world.robot])
    data.qpos[world.forks_qpos] = recording.fork_height_m[k] - LOW
    if len(world.walkers):
        swing = _swing(recording, k, world.walkers)
        data.qpos[world.legs_qpos] = np.stack((swing, -swing), axis=1)
    mujoco.mj_kinematics(world.model, data)


def _swing(recording: Recording, k: int, people: Index) -> FloatArray:
    """Return the angles (n,) of people's left legs, which follow from how far they have walked."""
    t, way = recording.t_s, recording.position[:, people, :2]
    first, last = max(k - 1, 0), min(k + 1, len(t) - 1)
    walked = np.linalg.norm(np.diff(way[: k + 1], axis=0), axis=-1).sum(axis=0)
    speed = np.linalg.norm(way[last] - way[first], axis=-1) / max(float(t[last] - t[first]), 1e-9)
    share = np.minimum(speed / STRIDING, 1.0)
    swing: FloatArray = SWING_RAD * share * np.sin(2 * np.pi * walked / STRIDE_M)
    return swing


def body_name(object_id: str) -> str:
    """Return the name of an object's body, which neither the forks nor the world have."""
    return f"object {object_id}"


def ground_of(context: Context) -> float:
    """Return the height of the ground under the robot, in metres."""
    return float(context.agent.trajectory.xyz[0, 2])


def _add_floor(spec: mujoco.MjSpec, ground_m: float) -> None:
    spec.worldbody.add_geom(
        name=FLOOR,
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        pos=[0, 0, ground_m],
        size=[0, 0, 1],
        friction=[FRICTION, 0.005, 0.0001],
        group=SOLID_GROUP,
    )


def _qpos(model: mujoco.MjModel, joints: list[int]) -> Index:
    addresses: Index = np.asarray(model.jnt_qposadr, dtype=np.int64)[np.array(joints, dtype=int)]
    return addresses
