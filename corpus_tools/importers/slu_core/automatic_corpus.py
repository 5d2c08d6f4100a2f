"""The random tasks in a larger yard: worlds, typed commands, and what was done.

A video is a folder in ``forklift.automatic.v1`` and the like. Nobody has annotated the commands,
so there are no clauses and no groundings. Outcomes are in ``simSupervisorStatus.txt``, the log of
the tasks' supervisor.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_statistics import statistics
from corpus_tools.corpus.start_headings import HeadingRule, turn_robot
from corpus_tools.importers.report import ImportReport, Journal
from corpus_tools.importers.slu_core import slu_files
from corpus_tools.importers.slu_core.automatic_worlds import (
    TRAILER,
    Remark,
    Things,
    place_robot,
    read_things,
)
from corpus_tools.importers.slu_core.slu_files import hash_subject
from corpus_tools.runtime.progress import OnProgress, no_progress
from g3.annotation import Command, TaskOutcome, Unknown
from g3.errors import FormatError
from g3.groundings import Context
from g3.short_repr import short_repr
from g3.storage.text_lines import split_lines

NAME = "forklift-automatic"
OBJECTS = "objects.xml"
PROPERTIES = "properties.yaml"
STATUS = "simSupervisorStatus.txt"
READ = (slu_files.ASSIGNMENTS, OBJECTS, PROPERTIES, STATUS)


@short_repr
@dataclass(frozen=True, slots=True)
class WorldFolders:
    """Folders of the worlds: folders of videos in folders of groups, relative to `data`."""

    data: Path
    folders: tuple[str, ...]


def import_automatic(
    found: WorldFolders,
    *,
    salt: str,
    heading: HeadingRule,
    keep_going: bool = False,
    on_progress: OnProgress = no_progress,
) -> tuple[Corpus, ImportReport]:
    """Read the random tasks, with robots that face as `heading` says, which isn't recorded.

    A context, a scenario and the folder have the same name, such as
    ``forklift.automatic.v1/2011-07-18-21-04-08_1_manip_0_dest``; a command adds its number.
    FormatError if a file is no YAML or no XML.
    """
    journal = Journal(keep_going)
    contexts: list[Context] = []
    commands: list[Command] = []
    outcomes: list[TaskOutcome] = []
    others: Counter[str] = Counter()
    for done, folder in enumerate(found.folders):
        on_progress("reading", done, len(found.folders))
        world = _World(found.data, folder, journal)
        others.update(p.name for p in world.path.iterdir() if p.name not in READ)
        video = world.video()
        typed = list(world.commands(salt, video))
        log = world.log()
        context = place_robot(world.name, world.things(), log.start, world.remark)
        contexts.append(turn_robot(context, heading))
        commands += typed
        outcomes += outcomes_of_log(log, context, world.only_video(typed, video), world.remark)
    journal.check()
    corpus = Corpus.build(
        NAME,
        contexts=contexts,
        commands=commands,
        annotations=(),
        outcomes=outcomes,
        source=f"{slu_files.SOURCE}; robots' headings and sizes of things that it doesn't tell "
        "are assumed",
        licence=slu_files.LICENCE,
    )
    return corpus, journal.report(slu_files.IMPORTER, _counts(corpus), dict(sorted(others.items())))


@dataclass(frozen=True, slots=True)
class _World:
    """The folder of a video."""

    data: Path
    folder: str
    journal: Journal

    @property
    def path(self) -> Path:
        return self.data / self.folder

    @property
    def name(self) -> str:
        return "/".join(self.path.parts[-2:])

    def remark(self, what: str, detail: str = "") -> None:
        self.journal.note(what, f"{self.name}: {detail}" if detail else self.name)

    def things(self) -> Things:
        text = self._text(OBJECTS)
        if text is None:
            self.remark("without objects.xml the world is empty but for the robot")
            return Things()
        try:
            return read_things(text, self.remark)
        except FormatError as error:
            self.journal.skip(f"{self.folder}/{OBJECTS}", "", error)
            return Things()

    def log(self) -> SupervisorLog:
        return read_log(self._text(STATUS) or "")

    def commands(self, salt: str, its_video: str) -> Iterator[Command]:
        records = self._yaml(slu_files.ASSIGNMENTS)
        if not isinstance(records, list):
            if records is not None:
                self._skip_record("", f"the file holds a {type(records).__name__}, not a list")
            records = []
        if not records:
            self.remark("nobody has typed a command")
        assignments: set[str] = set()
        for number, record in enumerate(records, start=1):
            if not isinstance(record, dict):
                self._skip_record(f"record {number}", "this is not a mapping")
                continue
            name = f"{self.name}-{number:02}"
            text = _scalar(record.get("command"))
            if not text.strip():
                self.journal.note("nothing was typed", name)
            assignment = _scalar(record.get("assignmentId"))
            if assignment and assignment in assignments:
                self.journal.note("an assignment occurs twice", name)
            assignments.add(assignment)
            video = _scalar(record.get("youtubeId")) or its_video
            subject = hash_subject(record.get("workerId"), salt)
            yield Command(name, text, self.name, video, subject)

    def only_video(self, typed: list[Command], video: str) -> str:
        """Return the video that shows this world, if its commands are of several videos."""
        videos = {command.video for command in typed}
        if len(videos) < 2:
            return ""
        self.remark("commands are of several videos; the outcome is that of one", video)
        return video

    def video(self) -> str:
        """Return the video that was made of this world; empty if it isn't recorded."""
        properties = self._yaml(PROPERTIES)
        return _scalar(properties.get("youtubeId")) if isinstance(properties, dict) else ""

    def _yaml(self, name: str) -> Any:
        text = self._text(name)
        if text is None:
            return None
        try:
            return slu_files.parse_yaml(text)
        except FormatError as error:
            self.journal.skip(f"{self.folder}/{name}", "", error)
            return None

    def _text(self, name: str) -> str | None:
        return slu_files.read_text(self.data, f"{self.folder}/{name}", self.journal)

    def _skip_record(self, record: str, what: str) -> None:
        fix = "write a list of mappings with command, workerId and youtubeId"
        self.journal.skip(
            f"{self.folder}/{slu_files.ASSIGNMENTS}", record, FormatError(what, fix=fix)
        )


def _scalar(value: object) -> str:
    return "" if value is None or isinstance(value, dict | list) else str(value)


def _counts(corpus: Corpus) -> dict[str, int]:
    told = statistics(corpus).outcomes
    return {
        "worlds of random tasks": len(corpus.contexts),
        "commands typed for them": len(corpus.commands),
        **{f"outcomes, {what}": count for what, count in told.items()},
    }


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
