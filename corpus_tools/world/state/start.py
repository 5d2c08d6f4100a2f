"""Start of a context: supports of its things, and the load on the forks.

Corpora have poses to some centimetres. Physics needs things to stand on each other exactly.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from corpus_tools.world.state.dimensions import ENTRY_HEIGHT, HEEL_X, LIFT_RANGE, LOW
from corpus_tools.world.state.shapes import Shape, shape_of
from corpus_tools.world.state.thing_kinds import kind_of
from g3.actions.logged_actions import at_rest, loaded
from g3.geometry.footprints import covers
from g3.geometry.plane import rotate, wrap
from g3.groundings import Context, FloatArray, PhysicalObject, Prism, Trajectory

HEEL_GAP_M = 0.01
"""Gap between the forks' heel and the load on them."""


def starting(context: Context, held: str | None = None) -> tuple[Context, str | None, float]:
    """Return a context as physics can start it, the load on the forks if any, and their height.

    Every object has one pose and the prism that it starts with. Loads stand exactly on what is
    under them. The load on the forks, which are so many metres up, is `held`, else what hangs in
    front of the robot or moves with it.
    """
    held = held or loaded(context)
    ground = float(context.agent.trajectory.xyz[0, 2])
    still = (replace(item, trajectory=at_rest(item.trajectory)) for item in context.objects)
    objects = {item.id: item for item in still}
    loads = [item for item in objects.values() if kind_of(item.labels).carriable]
    for load in sorted(loads, key=lambda item: item.prism.z_min):
        if load.id != held:
            bottom = _support(load, list(objects.values()), ground)
            objects[load.id] = moved(load, np.array([0, 0, bottom - load.prism.z_min]))
    forks = 0.0
    if held is not None and not kind_of(objects[held].labels).carriable:
        held = None
    if held is not None:
        objects[held] = _on_forks(objects[held], objects[context.agent_id].trajectory)
        up = objects[held].prism.z_min - ground + ENTRY_HEIGHT - LOW
        forks = min(max(up, 0.0), LIFT_RANGE)
        objects[held] = moved(objects[held], np.array([0, 0, forks - up]))
    return replace(context, objects=tuple(objects.values())), held, forks


def ahead_of(pose: FloatArray, shape: Shape, yaw: float) -> float:
    """Return the distance of a load's frame on the forks ahead of the robot's pose, shape (3,).

    `shape` and `yaw` are the load's box, and the heading of its frame.
    """
    corners = np.array([[x, y] for x in (0, 1) for y in (0, 1)]) * shape.size[:2] + shape.low[:2]
    back = rotate(corners, np.array(yaw - pose[2]))[:, 0].min()
    return HEEL_X + HEEL_GAP_M - float(back)


def moved(item: PhysicalObject, by: FloatArray) -> PhysicalObject:
    """Return an object with one pose, moved by metres along x, y and z."""
    pose, prism = item.trajectory, item.prism
    return replace(
        item,
        prism=Prism(prism.xy + by[:2], prism.z_min + float(by[2]), prism.z_max + float(by[2])),
        trajectory=Trajectory(pose.t, pose.xyz + by, pose.yaw),
    )


def _support(load: PhysicalObject, objects: list[PhysicalObject], ground: float) -> float:
    """Return the height under a load's middle that its bottom is nearest to."""
    middle = (load.prism.xy.min(axis=0) + load.prism.xy.max(axis=0)) / 2
    tops = [o.prism.z_max for o in objects if o.id != load.id and covers(o.prism, middle)]
    surfaces = np.array([ground, *(top for top in tops if top < load.prism.z_max)])
    return float(surfaces[np.argmin(np.abs(surfaces - load.prism.z_min))])


def _on_forks(load: PhysicalObject, robot: Trajectory) -> PhysicalObject:
    """Return the load straight on the forks, with its back at their heel."""
    pose = np.array([*robot.xyz[0, :2], robot.yaw[0]])
    frame, shape = load.trajectory, shape_of(load)
    quarter = np.pi / 2
    turn = float(wrap(pose[2] - frame.yaw[0]) % quarter)
    turn -= quarter if turn > quarter / 2 else 0.0
    yaw = frame.yaw + turn
    aside = -rotate(shape.middle[:2], yaw[0] - pose[2])[1]
    ahead = ahead_of(pose, shape, float(yaw[0]))
    xy = pose[:2] + rotate(np.array([ahead, aside]), pose[2])
    corners = rotate(load.prism.xy - frame.xyz[0, :2], np.full(len(load.prism.xy), turn))
    return replace(
        load,
        prism=Prism(corners + xy, load.prism.z_min, load.prism.z_max),
        trajectory=Trajectory(frame.t, np.array([[*xy, frame.xyz[0, 2]]]), yaw),
    )
