"""The automatic judge: comparison of a plan's end with the known end of the command.

It stands in for people in unattended evaluation, and its verdicts are labelled *automatic*.
:func:`judge` compares the objects moved, their end positions and the load on the forks with those
in the command's own log, within stated tolerances. Where no log has paths and positions,
:func:`judge_outcome` compares a plan with the record of the handled loads, and with all that this
says: the plan picks up the same loads and nothing else, and they end on the forks, on the ground,
or on one of the possible carriers. A load's position on the ground, and the goal of a robot that
only drove, are never known; any place will do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from g3.actions.action_kinds import Action
from g3.actions.grounding_candidates import beneath, carrier, square
from g3.actions.logged_actions import NOTHING, end_of, handling, moved, recorded
from g3.actions.robot_state import State, start_state
from g3.annotation import TaskOutcome
from g3.geometry.footprints import apart, centre
from g3.geometry.plane import convex_hull, point_gap
from g3.groundings import Context, FloatArray, PhysicalObject
from g3.short_repr import short_repr

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


@short_repr
@dataclass(frozen=True, slots=True)
class Expected:
    """A command's outcomes combined."""

    last: Mapping[str, TaskOutcome]
    """Last outcome of each object that was picked up."""
    is_whole: bool
    """True if nothing else was picked up."""
    is_determined: bool
    """True if nothing is unknown except the carrier of a load, of several that are right."""

    @property
    def picked(self) -> frozenset[str]:
        """Ids of objects known to be picked up."""
        return frozenset(self.last)

    @property
    def tells(self) -> bool:
        """True if anything is known by which a plan could be wrong."""
        return bool(self.last) or self.is_whole


def expected(outcomes: Sequence[TaskOutcome]) -> Expected:
    """Put the outcomes of a command together; they are in the order in which it was done."""
    unknown = {name for o in outcomes for name in o.unknown}
    return Expected(
        {thing: o for o in outcomes for thing in o.picked},
        bool(outcomes) and not unknown & {"picked", "rest"},
        bool(outcomes) and unknown <= {"on"},
    )


def judge_outcome(want: Expected, picked: frozenset[str], start: State, final: State) -> Verdict:
    """Compare a plan's loads (`picked_up`) and end state with the known outcomes."""
    missing, strange = want.picked - picked, picked - want.picked
    if missing:
        return Verdict(False, f"it doesn't pick up {', '.join(sorted(missing))}")
    if strange and want.is_whole:
        return Verdict(False, f"it picks up {', '.join(sorted(strange))}, which was left alone")
    if want.is_whole and not want.picked and final.held != start.held:
        return Verdict(False, "the load on the forks isn't the same; the robot only drove")
    wrong = [why for thing, o in want.last.items() if (why := _wrong_end(thing, o, final))]
    return Verdict(not wrong, next(iter(wrong), ""))


def _wrong_end(thing: str, outcome: TaskOutcome, final: State) -> str:
    """Return the error in an object's end position; empty if there is none, or it isn't known."""
    if not outcome.put or "put" in outcome.unknown:
        return ""
    if outcome.put == "held":
        return "" if final.held == thing else "the load isn't on the forks at the end"
    if final.held == thing:
        return "the load is on the forks at the end"
    under = carrier(final, thing)
    if outcome.put == "ground":
        return "" if under is None else "the load isn't on the ground"
    is_there = under is not None and (not outcome.on or under.id in outcome.on)
    return "" if is_there else "the load stands on something else"


def picked_up(start: State, actions: Sequence[Action], final: State) -> frozenset[str]:
    """Return the ids of loads that a plan picks up or moves, but for the one held at the start."""
    lifted = {a.object_id for a in actions if a.kind.takes}
    return frozenset(shifted(start, final) | lifted) - {start.held}


def picked_in_log(context: Context) -> frozenset[str]:
    """Return the ids of loads that are picked up in a context's own log."""
    if handling(context) == NOTHING:
        return frozenset()
    return moved(recorded(context)) - {start_state(context).held}
