"""The random tasks in a larger yard: worlds, typed commands, and what was done.

A video is a folder in ``forklift.automatic.v1`` and the like. Nobody has annotated the commands,
so there are no clauses and no groundings. Worlds are in ``objects.xml``, outcomes in
``simSupervisorStatus.txt``, the log of the tasks' supervisor.

Positions of pallets and trailers are a corner of the footprint, which lies ahead and to the
left of it. That was checked against the contexts of the paper's corpus, which are of the same
simulator, to 2 cm. Positions of other things are taken as their middles.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_statistics import statistics
from corpus_tools.corpus.start_headings import HeadingRule, turn_robot
from corpus_tools.importers.report import ImportReport, Journal
from corpus_tools.importers.slu_core import slu_files
from corpus_tools.importers.slu_core.slu_files import hash_subject
from corpus_tools.runtime.progress import OnProgress, no_progress
from g3.annotation import Command, TaskOutcome, Unknown
from g3.errors import FormatError
from g3.geometry.plane import rotate
from g3.groundings import Aspect, Context, FloatArray, PhysicalObject, Prism, Trajectory
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


Remark = Callable[..., None]
"""Function that receives an unusual aspect of a world, and its details."""

ROBOT = "-100"
"""Id of the robot, as in the paper's corpus."""
ROBOT_SIZE_M, ROBOT_HEIGHT_M = 1.5, 2.0
"""The paper's contexts have the forklift as a square around its position."""
START_AWAY_M = 10.0
"""Distance of the robot from the middle of everything, in metres, where no log gives its start."""


@dataclass(frozen=True, slots=True)
class _Model:
    """Labels of the things of a number, and their sizes in metres."""

    labels: tuple[str, ...]
    size: tuple[float, float]
    """Along and across the heading."""
    heights: tuple[float, float]
    """Bottom and top."""
    is_measured: bool = False
    """True if the sizes are those of the paper's contexts; else they are assumed."""
    is_corner: bool = False
    """True if the position is the corner behind and to the right, not the middle."""


def _pallet(*words: str, height: float, is_measured: bool = False) -> _Model:
    return _Model((*words, "pallet"), (1.2, 1.0), (0.0, height), is_measured, is_corner=True)


PALLETS: Mapping[str, _Model] = {
    "1": _pallet("bricks", height=0.8),
    "6": _pallet("generator", height=1.2),
    "7": _pallet("generator", "accessories", height=1.03, is_measured=True),
    "19": _pallet("refrigerator", height=1.9),
    "21": _pallet("tire", "assembly", height=0.7, is_measured=True),
    "22": _pallet("tire", height=0.7, is_measured=True),
    "25": _pallet("washing", "machine", height=1.1),
}
"""By the number in ``<label>``; the number in ``<type>`` is wrong for most."""

THINGS: Mapping[str, _Model] = {
    "1": _Model(("semi", "truck"), (6.0, 2.5), (0.0, 3.5)),
    "3": _Model(("flatbed", "truck"), (7.0, 2.4), (0.0, 1.1)),
    "5": _Model(
        ("flatbed", "trailer"), (5.36, 1.91), (0.44, 0.85), is_measured=True, is_corner=True
    ),
    "8": _Model(("operator",), (0.5, 0.5), (0.0, 1.75)),
    "10": _Model(("drum",), (0.6, 0.6), (0.0, 0.9)),
    "11": _Model(("ship", "container"), (6.06, 2.44), (0.0, 2.6)),
    "12": _Model(("sign", "post"), (0.4, 0.4), (0.0, 2.2)),
    "13": _Model(("berm",), (6.0, 2.0), (0.0, 1.0)),
}
"""By the number in ``<type>``."""

UNKNOWN_PALLET = _pallet(height=1.0)
UNKNOWN_THING = _Model(("object",), (1.0, 1.0), (0.0, 1.0))
TRAILER = ("flatbed", "trailer")

_NUMBERS = r"\s*([-+.\deE]+)[\s,]+([-+.\deE]+)[\s,]+([-+.\deE]+)(?:[\s,]+([-+.\deE]+))?\s*"
_NOT_IN_XML = re.compile(r"[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


@short_repr
@dataclass(frozen=True, slots=True)
class Things:
    """Things in a world, and their assumed properties."""

    objects: tuple[PhysicalObject, ...] = ()
    assumed: tuple[tuple[str, Aspect], ...] = ()


def read_things(text: str, remark: Remark) -> Things:
    """Read the content of ``objects.xml``; FormatError if it isn't XML.

    `remark` receives all that is unusual: unknown numbers, things without a position, and so on.
    """
    objects: dict[str, PhysicalObject] = {}
    assumed: list[tuple[str, Aspect]] = []
    for number, item in enumerate(_parsed(text), start=1):
        name = (item.findtext("id") or "").strip()
        if not name:
            name = f"item-{number}"
            remark("an item of objects.xml has no id; it gets one", name)
        elif name in objects or name == ROBOT:
            name = f"{name}-{number}"
            remark("two items of objects.xml have the same id; the second gets another", name)
        at = _values(item, "position", 3)
        if at is None:
            remark("an item of objects.xml has no position, so it is left out", name)
            continue
        model, aspects = _model(item, name, remark)
        yaw = _heading(item)
        if yaw is None:
            remark("an item of objects.xml has no orientation; 0 is assumed", name)
            aspects.append("heading")
        objects[name] = _thing(name, model, at, yaw or 0.0)
        assumed += [(name, aspect) for aspect in aspects]
    return Things(tuple(objects.values()), tuple(assumed))


def place_robot(
    name: str, things: Things, start: tuple[float, float] | None, remark: Remark
) -> Context:
    """Put the robot into a world. Its heading is 0 and marked as assumed.

    `name` is the context's id, `start` where the log puts the robot, in m; None if it doesn't say.
    """
    assumed: list[tuple[str, Aspect]] = [*things.assumed, (ROBOT, "heading")]
    if start is None:
        middles = [item.prism.xy.mean(axis=0) for item in things.objects] or [np.zeros(2)]
        x, y = np.mean(middles, axis=0)
        start = (float(x) - START_AWAY_M, float(y))
        assumed.append((ROBOT, "position"))
        remark(
            "the log doesn't tell where the robot starts; "
            f"{START_AWAY_M:g} m from the middle of all things is assumed"
        )
    half = ROBOT_SIZE_M / 2
    corners = np.array([[-half, -half], [half, -half], [half, half], [-half, half]]) + start
    robot = PhysicalObject(
        ROBOT,
        ("forklift",),
        Prism(corners, 0.0, ROBOT_HEIGHT_M),
        Trajectory(np.zeros(1), np.array([[*start, 0.0]]), np.zeros(1)),
    )
    return Context(name, (*things.objects, robot), (), ROBOT, tuple(assumed))


def _parsed(text: str) -> ElementTree.Element:
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise FormatError("the file declares entities", fix="remove the declarations")
    body = re.sub(r"^\s*<\?xml.*?\?>", "", _NOT_IN_XML.sub(" ", text), count=1, flags=re.DOTALL)
    try:
        return ElementTree.fromstring(body)  # noqa: S314 - without entities it can't grow
    except ElementTree.ParseError as error:
        raise FormatError(f"the file is not XML: {error}", fix="fetch the file again") from error


def _model(item: ElementTree.Element, name: str, remark: Remark) -> tuple[_Model, list[Aspect]]:
    """Return the kind of a thing, and which of its properties are assumed."""
    kind = item.get("type")
    is_pallet = kind == "pallet"
    if kind not in ("pallet", "object"):
        remark(f"an item of objects.xml is neither pallet nor object but {kind!r}", name)
    number = (item.findtext("label" if is_pallet else "type") or "").strip()
    model = (PALLETS if is_pallet else THINGS).get(number) if kind in ("pallet", "object") else None
    if model is None:
        what = "label of a pallet" if is_pallet else "type of an object"
        remark(f"unknown {what}: {number or 'none'}", name)
        return (UNKNOWN_PALLET if is_pallet else UNKNOWN_THING), ["labels", "size"]
    return model, ([] if model.is_measured else ["size"])


def _thing(name: str, model: _Model, at: FloatArray, yaw: float) -> PhysicalObject:
    length, width = model.size
    x, y = (0.0, 0.0) if model.is_corner else (-length / 2, -width / 2)
    corners = np.array([[x, y], [x, y + width], [x + length, y + width], [x + length, y]])
    # As in the paper's contexts, the second edge of a footprint points where the thing heads.
    footprint = rotate(corners, np.full(4, yaw)) + at[:2]
    # Only pallets stand on something; of other things the height is that of the yard's ground.
    base = float(at[2]) if "pallet" in model.labels else 0.0
    bottom, top = (base + height for height in model.heights)
    pose = np.array([[*footprint.mean(axis=0), (bottom + top) / 2]])
    prism = Prism(footprint, bottom, top)
    return PhysicalObject(name, model.labels, prism, Trajectory(np.zeros(1), pose, np.array([yaw])))


def _values(item: ElementTree.Element, tag: str, count: int) -> FloatArray | None:
    for found in item.findall(tag):
        match = re.fullmatch(_NUMBERS, found.text or "")
        if found.get("id") == "local-frame" and match:
            try:
                values = np.array([float(part) for part in match.groups() if part])
            except ValueError:
                continue
            if len(values) == count and np.isfinite(values).all():
                return values
    return None


def _heading(item: ElementTree.Element) -> float | None:
    """Return the heading of a quaternion w, x, y, z."""
    quaternion = _values(item, "orientation", 4)
    if quaternion is None or not np.linalg.norm(quaternion) > 0:
        return None
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    return float(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
