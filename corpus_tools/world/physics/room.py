"""What the robot must not run into, and where it can go straight in and out."""

from __future__ import annotations

import numpy as np

from corpus_tools.world.physics.controller import Load, Simulation
from corpus_tools.world.planning.clearance import Boxes, Rect, clearance, outline, room
from corpus_tools.world.state import dimensions as sizes
from corpus_tools.world.state.recording import heading
from corpus_tools.world.state.shapes import Shape
from corpus_tools.world.state.solids import beside_deck, cab_top
from corpus_tools.world.state.thing_kinds import kind_of
from g3.actions.driving import direction
from g3.geometry.plane import rotate
from g3.groundings import FloatArray

STRAIGHT_MARGIN_M = 0.03
"""Room that the robot keeps where it goes straight in to something."""
READY_MARGIN_M = 0.12
"""Room that it needs where it stops before it goes in, or turns away."""

_TINES_Y = sizes.FORK_Y + sizes.FORK_WIDTH / 2
CHASSIS_OUTLINE = outline((Rect((sizes.CHASSIS[0][0], sizes.MAST[0][1]), sizes.CHASSIS[1]),))
FORKS_OUTLINE = outline(
    (
        Rect((sizes.MAST[0][1], sizes.HEEL_X), sizes.BACKREST[1]),
        Rect((sizes.HEEL_X, sizes.HEEL_X + sizes.FORK_LENGTH), (-_TINES_Y, _TINES_Y)),
    )
)
_CHASSIS_Z = (sizes.MAST[2][0], sizes.MAST[2][1])


def load_rect(load: Load, shape: Shape) -> Rect:
    """What a load on the forks covers, in the robot's frame."""
    corners = np.array([[x, y] for x in (0, 1) for y in (0, 1)]) * shape.size[:2] + shape.low[:2]
    xy = load.xy + rotate(corners, np.array(load.yaw))
    (x0, y0), (x1, y1) = xy.min(axis=0).tolist(), xy.max(axis=0).tolist()
    return Rect((x0, x1), (y0, y1))


def robot_outline(sim: Simulation, load: Load | None) -> FloatArray:
    """The robot with a load on its forks, or without."""
    parts = [CHASSIS_OUTLINE, FORKS_OUTLINE]
    if load is not None:
        parts.append(outline((load_rect(load, sim.shape(load.id)),)))
    return np.concatenate(parts)


def boxes_of(sim: Simulation, *but: str | None) -> Boxes:
    """Everything but the robot, what is on its forks, and some objects; heights above ground."""
    held = sim.load.id if sim.load else None
    rows = []
    for item in sim.start.objects:
        if item.id in (sim.start.agent_id, held, *but):
            continue
        kind, shape = kind_of(item.labels), sim.shape(item.id)
        xyz, orientation = sim.body_pose(item.id)
        yaw, bottom = heading(orientation), xyz[2] - sim.ground_m
        (x0, y0, z0), (x1, y1, z1) = shape.low.tolist(), shape.high.tolist()
        under = 0.0 if kind.deck is not None else z0 + bottom
        solids = [(x0, x1, under, z1 + bottom)]
        if kind.deck is not None:
            solids += [
                (a, b, z1 + bottom, cab_top(z1 + bottom)) for a, b in beside_deck(kind, shape)
            ]
        for a, b, low, high in solids:
            middle = xyz[:2] + rotate(np.array([(a + b) / 2, (y0 + y1) / 2]), yaw)
            rows.append((*middle, float(yaw), (b - a) / 2, (y1 - y0) / 2, low, high))
    table = np.array(rows).reshape(-1, 7)
    return Boxes(table[:, :2], table[:, 2], table[:, 3:5], table[:, 5:])


def behind(pose: FloatArray, metres: float) -> FloatArray:
    """The pose straight back from another."""
    return np.array([*(pose[:2] - metres * direction(pose[2])), pose[2]])


def fits_straight(
    final: FloatArray, back_m: float, boxes: Boxes, carried: FloatArray, band: tuple[float, float]
) -> bool:
    """Whether the robot can go straight to a pose from some metres behind it.

    `carried` is the outline of the forks and what is on them, `band` between which heights these
    are.
    """
    steps = np.linspace(0, back_m, max(int(np.ceil(back_m / 0.1)), 1) + 1)
    poses = np.array([behind(final, step) for step in steps])
    if clearance(poses, CHASSIS_OUTLINE, boxes.between(*_CHASSIS_Z)) < STRAIGHT_MARGIN_M:
        return False
    return clearance(poses, carried, boxes.between(*band)) >= STRAIGHT_MARGIN_M


def ready_behind(
    final: FloatArray, around: FloatArray, boxes: Boxes, least_m: float, most_m: float = 4.0
) -> float | None:
    """How far behind a pose the robot is clear of everything; None if it nowhere is."""
    backs = np.arange(least_m, most_m, 0.1)
    poses = np.array([behind(final, back) for back in backs])
    free = room(poses, around, boxes) >= READY_MARGIN_M
    return float(backs[np.argmax(free)]) if free.any() else None


def forks_band(height_m: float) -> tuple[float, float]:
    """Between which heights the forks and their backrest are; the first is their upper side's."""
    return height_m - sizes.FORK_THICKNESS + 0.01, height_m + sizes.BACKREST[2][1]
