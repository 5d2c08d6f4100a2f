"""The automatic judge: comparison of a plan's end state with the end of the command's own log.

It stands in for people in unattended evaluation, and its verdicts are labelled *automatic*. It
compares the objects moved, their end positions and the load on the forks, within stated tolerances.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from g3.actions.grounding_candidates import beneath, square
from g3.actions.logged_actions import NOTHING, end_of, handling, moved, recorded
from g3.actions.robot_state import State, start_state
from g3.geometry.footprints import apart, centre
from g3.geometry.plane import convex_hull, point_gap
from g3.groundings import Context, FloatArray, PhysicalObject

MOVED_M = 0.5
"""Largest distance from its start at which an object counts as left alone, in metres."""
PLACE_M = 2.5
"""Largest distance of a load from its place at the end of the log, in metres."""
END_M = 3.0
"""Largest distance of the robot from the log's end, for commands that only drive, in metres."""
AT_M = 4.0
"""Largest distance to an object's border at which the robot is at it, in metres."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """A judge's verdict on a plan."""

    correct: bool
    """True if the plan did the same as the log."""
    reason: str = ""
    """The difference; empty if there is none."""


def judge(context: Context, final: State) -> Verdict:
    """Compare the state that a plan leads to with the end of a context's log."""
    start, log = start_state(context), recorded(context)
    done = handling(context)
    carried = moved(log) if done != NOTHING else frozenset()
    strange = shifted(start, final) - carried - {start.held, final.held}
    if strange:
        return Verdict(False, f"it moves {', '.join(sorted(strange))}, which the log leaves alone")
    if done == NOTHING:
        return _drive(start, log.agent, final)
    load = start.held if start.held in carried else sorted(carried)[0]
    if not done.leaves:
        if final.held != load:
            return Verdict(False, "the load isn't on the forks at the end")
        return Verdict(True)
    if final.held is not None:
        return Verdict(False, "a load is on the forks at the end")
    return _put(start, final, load, next(o for o in log.objects if o.id == load))


def _put(start: State, final: State, load: str, logged: PhysicalObject) -> Verdict:
    after = final.thing(load)
    goal, end = end_of(logged), centre(after.prism)
    rise = float(logged.trajectory.xyz[-1, 2] - logged.trajectory.xyz[0, 2])
    there = beneath(square(goal, 0.0, logged.prism.z_min + rise), start, load)
    here = beneath(square(end, 0.0, after.prism.z_min), start, load)
    if (there.id if there else None) != (here.id if here else None):
        return Verdict(False, "the load stands on something else")
    if there is not None:
        return Verdict(True)
    off = float(np.linalg.norm(goal - end))
    if off > PLACE_M:
        return Verdict(False, f"the load ends {off:.1f} m from where the log puts it")
    return Verdict(True)


def _drive(start: State, logged: PhysicalObject, final: State) -> Verdict:
    if final.held != start.held:
        return Verdict(False, "the load on the forks isn't the same")
    goal, end = logged.trajectory.xyz[-1, :2], final.pose[:2]
    off = float(np.linalg.norm(goal - end))
    if off <= END_M:
        return Verdict(True)
    there, here = (_nearest(start, p) for p in (goal, end))
    if there is not None and there == here:
        return Verdict(True)
    return Verdict(False, f"the robot ends {off:.1f} m from where the log ends")


def _nearest(state: State, point: FloatArray) -> str | None:
    """Return the id of the object that the robot is at; None if there is none."""
    gaps = [
        (float(point_gap(point[None, None], convex_hull(o.prism.xy)[None])[0, 0]), o.id)
        for o in state.context.objects
        if o.id not in (state.context.agent_id, state.held)
    ]
    nearest = min(gaps, default=(np.inf, ""))
    return nearest[1] if nearest[0] <= AT_M else None


def shifted(start: State, final: State) -> set[str]:
    """Return the ids of all objects that end elsewhere."""
    before = {o.id: o for o in start.context.objects}
    return {
        o.id
        for o in final.context.objects
        if o.id != start.context.agent_id and apart(before[o.id].prism, o.prism) > MOVED_M
    }
