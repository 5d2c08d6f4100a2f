"""The automatic judge for commands with known outcomes and no log: loads, and where they end.

There is no log with paths and positions, only a record of the handled loads. A plan must agree with
all that is known: it picks up the same loads and nothing else. They end on the forks, on the
ground, or on one of the possible carriers. A load's position on the ground, and the goal of a robot
that only drove, are never known; any place will do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from eval.judging.judge import Verdict
from g3.actions.grounding_candidates import carrier
from g3.actions.robot_state import State
from g3.annotation import TaskOutcome
from g3.short_repr import short_repr


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
