"""Outcomes of random tasks, from ``simSupervisorStatus.txt``, the log of their supervisor."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

from corpus_tools.importers.slu_core.automatic_worlds import TRAILER, Remark
from g3.annotation import TaskOutcome, Unknown
from g3.groundings import Context
from g3.short_repr import short_repr
from g3.storage.text_lines import split_lines

NUMBER = r"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?"
START = re.compile(rf"Teleporting to: ({NUMBER}), ({NUMBER})(?:, {NUMBER})*\.?")
DRIVE = re.compile(r"Generating Summoning Pose: Destination is checkpoint_id = (\d+)\.?")
LIFT = re.compile(
    r"Generating PMC Task: Pickup pallet_id = (?P<load>\d+)(?:"
    r"(?P<held> without a drop-off)|(?P<on> and drop-off on trailer)"
    r"|(?: and drop-off at checkpoint_id = (?P<checkpoint>\d+)))\.?"
)
TASK = "Generating"
DONE = "Looks like we're done"
SAYS_NOTHING = re.compile(
    r"|Starting\.+|ok|entering while loop|(manipulations|destinations): \d+"
    r"|on_pallet_list\(\): Added \d+ pallets|on_object_list\(\): Added \d+ trailers"
    r"|(Start|Currently) \d+ manipulation and \d+ summoning tasks remaining\.?"
    rf"|x, y, {NUMBER}, {NUMBER} dist: {NUMBER}|dist < \d+: [01]"
)
"""Lines that record no execution."""


@short_repr
@dataclass(frozen=True, slots=True)
class SupervisorLog:
    """Content of a supervisor's log."""

    start: tuple[float, float] | None = None
    """The robot's position at the start, in m."""
    tasks: tuple[str, ...] = ()
    """The lines about tasks, in order."""
    strange: tuple[str, ...] = ()
    """Lines of an unknown form, except for those of `tasks`."""
    is_complete: bool = False
    """True if the log ends as logs do."""


def read_log(text: str) -> SupervisorLog:
    """Read ``simSupervisorStatus.txt``. Any content can be read."""
    lines = [line.strip() for line in split_lines(text)]
    starts = [(float(m[1]), float(m[2])) for line in lines if (m := START.fullmatch(line))]
    return SupervisorLog(
        start=starts[0] if starts else None,
        tasks=tuple(line for line in lines if line.startswith(TASK)),
        strange=tuple(line for line in lines if _is_strange(line)),
        is_complete=DONE in lines,
    )


def _is_strange(line: str) -> bool:
    known = line == DONE or line.startswith(TASK) or START.fullmatch(line)
    return not known and SAYS_NOTHING.fullmatch(line) is None


def outcomes_of_log(
    log: SupervisorLog, context: Context, video: str, remark: Remark
) -> tuple[TaskOutcome, ...]:
    """Return a record for each task; one with everything unknown if the log has none.

    The scenario is named as `context`, its world. `video` is its only video that shows it; empty if
    it is every one. `remark` receives all that isn't understood.
    """
    for line in log.strange:
        remark("a line of the log isn't understood", line)
    if not log.tasks:
        remark("the log tells of no task, so what was done is unknown")
    elif not log.is_complete:
        remark("the log doesn't end as logs do, so more may have been done")
    read = [_outcome(line, context, remark) for line in log.tasks] or [
        _unnamed(context, unknown=("picked", "put", "place"))
    ]
    rest: tuple[Unknown, ...] = () if log.is_complete and not log.strange else ("rest",)
    return tuple(
        replace(
            outcome,
            id=f"{context.id}/{number}",
            video=video,
            unknown=tuple(dict.fromkeys((*outcome.unknown, *rest))),
        )
        for number, outcome in enumerate(read, start=1)
    )


def _unnamed(context: Context, unknown: Sequence[Unknown] = (), log: str = "") -> TaskOutcome:
    return TaskOutcome("", context.id, context.id, unknown=tuple(unknown), log=log)


def _outcome(line: str, context: Context, remark: Remark) -> TaskOutcome:
    drive, lift = DRIVE.fullmatch(line), LIFT.fullmatch(line)
    if drive:
        # Where checkpoints are is in a route file that was not published.
        return replace(_unnamed(context, ("place",), line), checkpoint=int(drive[1]))
    if lift is None:
        return _not_understood(line, context, remark)
    outcome = _picked(_unnamed(context, log=line), lift["load"], context, remark)
    if lift["held"]:
        return replace(outcome, put="held")
    if lift["checkpoint"]:
        return replace(
            outcome,
            put="ground",
            checkpoint=int(lift["checkpoint"]),
            unknown=(*outcome.unknown, "place"),
        )
    trailers = tuple(
        o.id for o in context.objects if o.labels == TRAILER and o.id not in outcome.picked
    )
    which: tuple[Unknown, ...] = () if len(trailers) == 1 else ("on",)
    if not trailers:
        remark("a load is put on a trailer, and objects.xml has none for it")
    return replace(outcome, put="on", on=trailers, unknown=(*outcome.unknown, *which))


def _picked(outcome: TaskOutcome, load: str, context: Context, remark: Remark) -> TaskOutcome:
    if load != context.agent_id and any(o.id == load for o in context.objects):
        return replace(outcome, picked=(load,))
    remark("what was picked up is not in objects.xml", load)
    return replace(outcome, unknown=(*outcome.unknown, "picked"))


def _not_understood(line: str, context: Context, remark: Remark) -> TaskOutcome:
    """Return the known part of a task of an unknown form: its load and its checkpoint."""
    remark("a task of the log isn't understood", line)
    outcome = _unnamed(context, ("put", "place"), line)
    checkpoint = re.search(r"checkpoint_id = (\d+)", line)
    if checkpoint:
        outcome = replace(outcome, checkpoint=int(checkpoint[1]))
    load = re.search(r"pallet_id = (\d+)", line)
    if load:
        return _picked(outcome, load[1], context, remark)
    return replace(outcome, unknown=("picked", *outcome.unknown))
