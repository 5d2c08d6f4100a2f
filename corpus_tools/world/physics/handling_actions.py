"""Actions that lift loads, put them down, and move the forks with their load."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import compress, islice
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from corpus_tools.world.physics import room
from corpus_tools.world.physics.behaviours import ActionError, Goal, Load, Robot, behaviour
from corpus_tools.world.physics.driving_actions import SHIFT_COST, go
from corpus_tools.world.physics.pacing import CAREFUL
from corpus_tools.world.planning.clearance import outline
from corpus_tools.world.state import dimensions as sizes
from corpus_tools.world.state.recording import heading
from corpus_tools.world.state.robot_script import LOWER_FORKS, PICK_UP, PUT_DOWN, RAISE_FORKS
from corpus_tools.world.state.start import HEEL_GAP_M
from corpus_tools.world.state.thing_kinds import kind_of
from g3.actions.courses import direction, quarters
from g3.geometry.footprints import centre
from g3.geometry.plane import rotate
from g3.groundings import FloatArray, Place

CARRY_M = 0.12
"""Height of carried loads above the ground, in metres."""
CLEAR_M = 0.15
"""Height of loads above their support, or above the surface that they go onto, in metres."""
LOOSE_M = 0.02
"""Height to which loads are lifted to test whether they come up, in metres."""
ENTER_M, LEAVE_M = sizes.FORK_LENGTH + 0.25, 0.5
"""Straight ways in metres: of forks into and out of a load, and of loads out, at least."""
NARROWEST_M = 2 * (sizes.FORK_Y + sizes.FORK_WIDTH / 2 + sizes.BLOCK) + 0.02
"""Loads must be so wide for the forks to find their openings."""
EPSILON_M = 0.02
"""Height above a load's support, in metres, below which a thing is not in its way."""
LONG_COST_M = 5.0
"""Cost of lifting a load lengthwise, in metres of way: it reaches less far over decks."""
SETTLE_S = 0.3
AT_ONCE = 64
"""Number of spots that are looked at together: numpy is slow for one."""


_Spot: TypeAlias = tuple[FloatArray, FloatArray, FloatArray]
"""Distance of a spot from a place's middle, pose of a load's frame there, and the robot's pose."""


@dataclass(frozen=True, slots=True, eq=False)
class _Docking:
    """A pose that the robot goes straight into and out of, with its goal and cost."""

    final: FloatArray
    """Pose at which it stops inside."""
    run_in_m: float
    run_out_m: float
    """Lengths of the straight ways in and out, in metres."""
    goal: Goal
    """Pose of the load afterwards."""
    cost: float
    """Cost of choosing it, in metres of way."""


@behaviour(PICK_UP)
def pick_up(robot: Robot, thing: str) -> Goal:
    """Drive up to a load, put the forks in, lift it, and back out with it."""
    if robot.load is not None:
        raise ActionError(
            f"the robot can't pick up {thing}: {robot.load.id} is on the forks already",
            fix="put it down before",
        )
    if not kind_of(robot.start.objects[robot.index(thing)].labels).carriable:
        raise ActionError(f"the forks can't lift {thing}")
    bottom = _bottom(robot, thing)
    carrier = room.carrier_under(robot, thing)
    docking = _dock(robot, _to_pick(robot, thing, bottom), f"to {thing} to pick it up", carrier)
    robot.lift(bottom)
    robot.grip, robot.support = thing, carrier
    robot.drive(((docking.run_in_m, 0.0),), CAREFUL)
    touching = bottom + sizes.ENTRY_HEIGHT - sizes.LOW
    robot.lift(touching + LOOSE_M)
    robot.take(thing)
    if _bottom(robot, thing) < bottom + LOOSE_M / 2:
        raise ActionError(f"{thing} did not come up with the forks")
    robot.lift(touching + CLEAR_M)
    robot.drive(((-docking.run_out_m, 0.0),), CAREFUL)
    robot.support = None
    robot.lift(sizes.ENTRY_HEIGHT - sizes.LOW + CARRY_M)
    return docking.goal


@behaviour(PUT_DOWN)
def put_down(robot: Robot, place: Place) -> Goal:
    """Put the load on the forks down on the support in the middle of a place, and back off.

    Where the middle is taken or out of reach, the load goes to the free spot of the place
    that is nearest to it. Forks reach over a deck as far as the load on them is long.
    """
    if robot.load is None:
        raise ActionError("nothing is on the forks to put down", fix="pick something up before")
    support = room.support_at(robot, place)
    where = f"to put {robot.load.id} down in {place.name or 'the place'}"
    docking = _dock(robot, _to_put(robot, robot.load, place, support), where, support.carrier)
    standing = support.height + sizes.ENTRY_HEIGHT - sizes.LOW
    if robot.forks_m < standing + CLEAR_M / 2:
        robot.lift(standing + CLEAR_M)
    robot.support = support.carrier
    robot.drive(((docking.run_in_m, 0.0),), CAREFUL)
    robot.lift(support.height)
    robot.load = None
    robot.wait(SETTLE_S)
    robot.drive(((-docking.run_out_m, 0.0),), CAREFUL)
    robot.grip = robot.support = None
    robot.lift(0.0)
    return docking.goal


def _dock(robot: Robot, dockings: list[_Docking], where: str, carrier: str | None) -> _Docking:
    """Drive to the start of one of several dockings."""
    if not dockings:
        reach = "" if carrier is None else f"the forks don't reach so far over {carrier}, or "
        raise ActionError(f"the robot can't get {where}: {reach}there is no room to go in and out")
    ready = np.array([room.behind(d.final, d.run_in_m) for d in dockings])
    return dockings[go(robot, ready, where, np.array([d.cost for d in dockings]))]


def _to_pick(robot: Robot, thing: str, bottom: float) -> list[_Docking]:
    """Return the dockings by which the forks can lift a load."""
    shape, (xyz, orientation) = robot.shape(thing), robot.body_pose(thing)
    yaw = float(heading(orientation))
    middle = xyz[:2] + rotate(shape.middle[:2], np.array(yaw))
    others, everything = room.boxes_of(robot, thing), room.boxes_of(robot)
    band = (bottom + EPSILON_M, bottom + CLEAR_M + float(shape.size[2]))
    found = []
    for side, entry in enumerate(quarters(yaw)):
        long, wide = shape.size[:2] if side % 2 == 0 else shape.size[1::-1]
        if wide < NARROWEST_M:
            continue
        final = np.array(
            [*(middle - (sizes.HEEL_X + HEEL_GAP_M + long / 2) * direction(entry)), entry]
        )
        held = Load(thing, rotate(xyz[:2] - final[:2], -entry), yaw - float(entry))
        load = outline((room.load_rect(held, shape),))
        run_in = room.ready_behind(final, room.robot_outline(robot, None), everything, ENTER_M)
        run_out = room.ready_behind(final, room.robot_outline(robot, held), others, LEAVE_M)
        if run_in is None or run_out is None:
            continue
        goes_in = room.fits_straight(
            final, run_in, others, room.FORKS_OUTLINE, room.forks_band(bottom + sizes.LOW)
        )
        if goes_in and room.fits_straight(final, run_out, others, load, band):
            xy = xyz[:2] - run_out * direction(entry)
            z = robot.ground_m + CARRY_M - float(shape.low[2])
            goal = Goal(thing, np.array([*xy, z]), yaw)
            cost = run_in + run_out + (LONG_COST_M if long > wide + EPSILON_M else 0.0)
            found.append(_Docking(final, run_in, run_out, goal, cost))
    return found


def _to_put(robot: Robot, load: Load, place: Place, support: room.Support) -> list[_Docking]:
    """Return the dockings for putting the load down in a place, as near to its middle as can be."""
    shape, boxes, height = robot.shape(load.id), room.boxes_of(robot), support.height
    rect = room.load_rect(load, shape)
    corners = np.array([[x, y] for x in rect.x for y in rect.y])
    around = room.robot_outline(robot, load)
    carried = np.concatenate((room.FORKS_OUTLINE, outline((rect,))))
    band = (height + EPSILON_M, height + CLEAR_M + float(shape.size[2]))
    found = []
    for yaw in quarters(support.axis):
        entry = yaw - load.yaw
        inside = rotate(corners - corners.mean(axis=0), np.full(4, entry))
        off, ahead = rotate(shape.middle[:2], yaw), rotate(load.xy, entry)
        spots = (
            (shift, xy, np.array([*(xy - ahead), entry]))
            for shift in room.spots(place, inside)
            if support.holds(centre(place.prism) + shift)
            for xy in (centre(place.prism) + shift - off,)
        )
        fits = partial(room.fits, boxes=boxes, carried=carried, band=band)
        for shift, xy, final in _fitting(spots, fits):
            run_in = room.ready_behind(final, around, boxes, ENTER_M)
            run_out = room.ready_behind(final, room.robot_outline(robot, None), boxes, ENTER_M)
            if run_in is None or run_out is None:
                continue
            out = room.fits_straight(
                final, run_out, boxes, room.FORKS_OUTLINE, room.forks_band(height + sizes.LOW)
            )
            if out and room.fits_straight(final, run_in, boxes, carried, band):
                near = float(np.hypot(*shift)) <= room.NUDGE_M + 1e-9
                at = xy - shift if near else xy
                z = robot.ground_m + height - float(shape.low[2])
                cost = run_in + run_out + SHIFT_COST * float(np.hypot(*shift))
                goal = Goal(load.id, np.array([*at, z]), float(yaw))
                found.append(_Docking(final, run_in, run_out, goal, cost))
                break
    return found


def _fitting(
    spots: Iterator[_Spot], fits: Callable[[FloatArray], npt.NDArray[np.bool_]]
) -> Iterator[_Spot]:
    """Yield the spots at which the robot has room, in their order."""
    while some := list(islice(spots, AT_ONCE)):
        yield from compress(some, fits(np.array([final for *_, final in some])))


def _bottom(robot: Robot, thing: str) -> float:
    """Return the height of an object's underside above the ground."""
    return float(robot.body_pose(thing)[0][2] + robot.shape(thing).low[2] - robot.ground_m)


NOTHING_M = 1e-3
"""Forks that are so near to a height are there."""


@behaviour(RAISE_FORKS)
def raise_forks(robot: Robot, distance_m: float) -> None:
    """Raise the forks by a distance, or as far as they go."""
    _brought_to(robot, min(robot.forks_m + distance_m, sizes.LIFT_RANGE))


@behaviour(LOWER_FORKS)
def lower_forks(robot: Robot, distance_m: float) -> None:
    """Lower the forks by a distance, or as far as they go; a load stays off the ground."""
    lowest = 0.0 if robot.load is None else sizes.ENTRY_HEIGHT - sizes.LOW + CARRY_M
    _brought_to(robot, min(max(robot.forks_m - distance_m, lowest), robot.forks_m))


def _brought_to(robot: Robot, height_m: float) -> None:
    if abs(height_m - robot.forks_m) > NOTHING_M:
        robot.lift(height_m)
