"""Reading of a corpus's files, with errors that name the problem, its place and its fix.

Functions that convert a record raise :class:`g3.errors.FormatError` whose ``where`` is the field
inside the record; :func:`read_content` adds the file and the record.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, NoReturn, TypeVar

import msgspec

from corpus_tools.corpus import corpus_records as records
from corpus_tools.corpus.corpus_records import (
    ANNOTATIONS,
    COMMANDS,
    CONTEXTS,
    JUDGMENTS,
    MANIFEST,
    OUTCOMES,
    TRAJECTORIES,
    AnnotationRecord,
    CommandRecord,
    ContextRecord,
    JudgmentRecord,
    Manifest,
    OutcomeRecord,
)
from corpus_tools.corpus.corpus_tables import (
    Arrays,
    Content,
    Tables,
    problems,
    read_arrays,
    unpack_one,
)
from corpus_tools.runtime.atomic_folder import recover
from corpus_tools.tables.json_text import explained
from g3.annotation import Annotation, Command, Judgment, TaskOutcome
from g3.errors import FormatError
from g3.groundings import Context, Grounding, PhysicalObject, Place, Prism, Trajectory
from g3.groundings import Path as WayGrounding
from g3.sdc.clauses import SDC, Span, breadth_first
from g3.short_repr import short_repr
from g3.storage import regular_file
from g3.storage.text_lines import place_in

T = TypeVar("T")
R = TypeVar("R", ContextRecord, CommandRecord, AnnotationRecord, JudgmentRecord, OutcomeRecord)
OnProblem = Callable[[FormatError], None]
"""Called with each problem; where it returns, the record with the problem is left out."""
GetTrajectory = Callable[[int, str], Trajectory]
"""The trajectory with a number; the second argument is the field that asks for it."""


@dataclass(frozen=True, slots=True)
class _Line(Generic[R]):
    where: str
    """File, line number and id."""
    record: R


def refuse(problem: FormatError) -> NoReturn:
    """Raise a problem, for readers that refuse any."""
    raise problem


def read_manifest(folder: Path) -> Manifest:
    """Read corpus.json."""
    fix = "give the folder of a corpus; `ct import --help` tells how to make one"
    recover(folder)
    if not folder.exists():
        raise FormatError("there is no such folder", where=str(folder), fix=fix)
    path = folder / MANIFEST
    if not path.is_file():
        raise FormatError(f"this is not a corpus: it has no {MANIFEST}", where=str(folder), fix=fix)
    content = regular_file.read_bytes(path)
    version = _decode(content, dict[str, msgspec.Raw], str(path)).get("schema_version")
    if version is None or bytes(version) not in (b"1", b"2"):
        found_version = "none" if version is None else bytes(version).decode(errors="replace")
        raise FormatError(
            f"the format's version is {found_version}, this program reads 1 and 2",
            where=f"{path}: schema_version",
            fix="import the corpus again, or use the program's version that wrote it",
        )
    return _decode(content, Manifest, str(path))


def read_files(folder: Path, on_problem: OnProblem) -> tuple[Manifest, Content, Tables]:
    """Read a corpus, and compare its content with its manifest.

    Each problem of a record is given to `on_problem`. A corpus that can't be read at all (no
    corpus, a missing file) raises FormatError.
    """
    manifest = read_manifest(folder)
    content, tables = read_content(folder, manifest, on_problem)
    for problem in problems(manifest, tables, str(folder)):
        on_problem(problem)
    return manifest, content, tables


def read_content(folder: Path, manifest: Manifest, on_problem: OnProblem) -> tuple[Content, Tables]:
    """Read the content of a corpus, even if it differs from its manifest."""
    arrays = read_arrays(folder / TRAJECTORIES)
    trajectory = _trajectory_reader(arrays)

    def read(name: str, record_type: type[R], convert: Callable[[R], T]) -> tuple[list[R], list[T]]:
        """Read the records of a file, and convert the valid ones."""
        lines = _read_lines(folder / name, record_type, on_problem)
        return [line.record for line in lines], list(_convert(lines, convert, on_problem))

    context_records, decoded_contexts = read(
        CONTEXTS, ContextRecord, lambda record: context(record, trajectory)
    )
    contexts = {context.id: context for context in decoded_contexts}
    command_records, typed = read(COMMANDS, CommandRecord, command)
    commands = {command.id: command for command in typed}
    objects = {(c.id, item.id): item for c in decoded_contexts for item in c.objects}
    world = World(commands, contexts, objects)
    annotation_records, annotations = read(
        ANNOTATIONS,
        AnnotationRecord,
        lambda record: annotation(record, world, trajectory),
    )
    judgment_records, judgments = read(JUDGMENTS, JudgmentRecord, judgment)
    outcome_records, outcomes = list[OutcomeRecord](), list[TaskOutcome]()
    if manifest.counts.outcomes or (folder / OUTCOMES).exists():
        outcome_records, outcomes = read(
            OUTCOMES, OutcomeRecord, lambda record: outcome(record, world)
        )
    tables = Tables(
        context_records,
        command_records,
        annotation_records,
        judgment_records,
        arrays,
        outcome_records,
    )
    content = Content(contexts, commands, tuple(annotations), tuple(judgments), tuple(outcomes))
    return content, tables


def _trajectory_reader(arrays: Arrays) -> GetTrajectory:
    cache: dict[int, Trajectory] = {}
    count = len(arrays["offsets"]) - 1

    def trajectory(index: int, field: str) -> Trajectory:
        if index >= count:
            raise FormatError(
                f"no trajectory {index}: {TRAJECTORIES} holds {count}",
                where=field,
                fix="correct the number, or restore the file",
            )
        if index not in cache:
            cache[index] = unpack_one(arrays, index)
        return cache[index]

    return trajectory


def _read_lines(path: Path, record_type: type[R], on_problem: OnProblem) -> list[_Line[R]]:
    """Read the records of a JSONL file, and check that their ids differ."""
    try:
        content = regular_file.read_bytes(path)
    except OSError as error:
        raise FormatError(
            f"the file can't be read: {error.strerror}",
            where=str(path),
            fix="restore the file, or import the corpus again",
        ) from error
    rows = content.removesuffix(b"\n").split(b"\n") if content else []
    if content and not content.endswith(b"\n"):
        on_problem(
            FormatError(
                "the last line is cut off",
                where=f"{path}: line {len(rows)}",
                fix="restore the file; each line ends with a newline",
            )
        )
    decoder = msgspec.json.Decoder(record_type)
    lines: list[_Line[R]] = []
    first: dict[str, int] = {}
    for number, line in enumerate(rows, start=1):
        where = f"{path}: line {number}"
        try:
            record = _decode_with(decoder, line, where)
            if record.id in first:
                raise FormatError(
                    f"the id {record.id!r} is also that of line {first[record.id]}",
                    where=f"{where}: id",
                    fix="give each record an id of its own",
                )
        except FormatError as problem:
            on_problem(problem)
            continue
        first[record.id] = number
        lines.append(_Line(f"{where} ({record.id})", record))
    return lines


def _convert(
    lines: list[_Line[R]], convert: Callable[[R], T], on_problem: OnProblem
) -> Iterator[T]:
    for line in lines:
        try:
            result = convert(line.record)
        except FormatError as problem:
            where = f"{line.where}: {problem.where}"
            on_problem(FormatError(problem.what, where=where, fix=problem.fix))
            continue
        yield result


def _decode(content: bytes, record_type: type[T], where: str) -> T:
    return _decode_with(msgspec.json.Decoder(record_type), content, where)


def _decode_with(decoder: msgspec.json.Decoder[T], content: bytes, where: str) -> T:
    try:
        return decoder.decode(content)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        text = content.decode(errors="replace")
        what, field, offset = explained(error, text)
        line, column = place_in(text, offset, "\n")
        place = f"{where}{'' if line == 1 else f': line {line}'}, column {column}"
        raise FormatError(
            what,
            where=f"{where}: {field}" if field else place,
            fix="correct the record; docs/schemas describes it",
        ) from error


@short_repr
@dataclass(frozen=True, slots=True)
class World:
    """Things that annotations refer to, each by its id."""

    commands: Mapping[str, Command]
    contexts: Mapping[str, Context]
    objects: Mapping[tuple[str, str], PhysicalObject]
    """By the ids of the context and of the object."""


def context(record: records.ContextRecord, trajectory: GetTrajectory) -> Context:
    """Decode a context, and check its agent and the ids of its objects."""
    objects = tuple(
        _object(item, f"objects[{i}]", trajectory) for i, item in enumerate(record.objects)
    )
    ids = [item.id for item in objects]
    for i, name in enumerate(ids):
        if name in ids[:i]:
            raise FormatError(
                f"a second object has the id {name!r}",
                where=f"objects[{i}].id",
                fix="give each object of a context an id of its own",
            )
    if record.agent_id not in ids:
        raise FormatError(
            f"the agent {record.agent_id!r} is not among the objects",
            where="agent_id",
            fix="name one of the objects, or add the agent to them",
        )
    places = tuple(_place(item, f"places[{i}]") for i, item in enumerate(record.places))
    for i, (name, _) in enumerate(record.assumed):
        if name not in ids:
            raise FormatError(
                f"no object has the id {name!r}",
                where=f"assumed[{i}]",
                fix="name one of the objects, or leave this out",
            )
    return Context(record.id, objects, places, record.agent_id, record.assumed)


def command(record: records.CommandRecord) -> Command:
    """Decode a command."""
    return Command(record.id, record.text, record.scenario, record.video, record.subject)


def judgment(record: records.JudgmentRecord) -> Judgment:
    """Decode a judgment."""
    return Judgment(**msgspec.structs.asdict(record))


def outcome(record: records.OutcomeRecord, world: World) -> TaskOutcome:
    """Decode the outcome of a task, and check its ids and that its parts fit together."""
    if record.context not in world.contexts:
        raise _unknown("context", record.context, "contexts.jsonl")
    if record.command:
        its_command = world.commands.get(record.command)
        if its_command is None:
            raise _unknown("command", record.command, "commands.jsonl")
        if its_command.scenario != record.scenario:
            raise FormatError(
                f"the command's scenario is {its_command.scenario!r}, not {record.scenario!r}",
                where="scenario",
                fix="correct one of them",
            )
    for field, names in (("picked", record.picked), ("on", record.on)):
        for i, name in enumerate(names):
            thing = (record.context, name)
            if thing not in world.objects or name == world.contexts[record.context].agent_id:
                raise FormatError(
                    f"no thing {name!r} in the context {record.context!r}",
                    where=f"{field}[{i}]",
                    fix=f"correct the id; if it isn't known, write {field!r} into 'unknown'",
                )
    for what, where in _contradictions(record):
        raise FormatError(what, where=where, fix="correct one of them")
    return TaskOutcome(**msgspec.structs.asdict(record))


def _contradictions(record: records.OutcomeRecord) -> Iterator[tuple[str, str]]:
    """Yield the fields of an outcome that contradict others, each with the reason."""
    unknown = set(record.unknown)
    if record.put and not record.picked and "picked" not in unknown:
        yield "something was put somewhere, but nothing was picked up", "put"
    if record.put and "put" in unknown:
        yield "it says where things were put, and also that it is unknown", "put"
    if record.on and record.put != "on":
        yield f"it names what things were put on, while 'put' is {record.put!r}", "on"
    if record.put == "on" and len(record.on) != 1 and "on" not in unknown:
        yield f"{len(record.on)} things to be put on, and 'on' is not among the unknown", "on"
    if set(record.picked) & set(record.on):
        yield "a thing is picked up and put on itself", "on"
    if len(unknown) < len(record.unknown):
        yield "something occurs twice", "unknown"


def annotation(
    record: records.AnnotationRecord, world: World, trajectory: GetTrajectory
) -> Annotation:
    """Decode an annotation, and check its references, words and lengths."""
    its_command = world.commands.get(record.command)
    if its_command is None:
        raise _unknown("command", record.command, "commands.jsonl")
    its_context = world.contexts.get(record.context)
    if its_context is None:
        raise _unknown("context", record.context, "contexts.jsonl")
    sdcs = tuple(_sdc(item, f"sdcs[{i}]", its_command.text) for i, item in enumerate(record.sdcs))
    clauses = sum(1 for _ in breadth_first(sdcs))
    for field, values in (("groundings", record.groundings), ("correct", record.correct)):
        if len(values) != clauses:
            raise FormatError(
                f"{len(values)} entries for {clauses} clauses",
                where=field,
                fix="one entry for each clause, breadth first",
            )
    groundings = tuple(
        tuple(
            _grounding(item, f"groundings[{i}][{k}]", record.context, world, trajectory)
            for k, item in enumerate(items)
        )
        for i, items in enumerate(record.groundings)
    )
    return Annotation(
        record.id,
        its_command,
        its_context,
        sdcs,
        groundings,
        record.correct,
        record.source,
        _words(record.taken_back, its_command.text, "taken_back"),
    )


def _unknown(field: str, name: str, file: str) -> FormatError:
    return FormatError(
        f"no {field} {name!r}", where=field, fix=f"add it to {file}, or correct the id"
    )


def _prism(record: records.PrismRecord, field: str) -> Prism:
    try:
        return Prism(record.xy, record.z_min, record.z_max)  # type: ignore[arg-type]
    except ValueError as error:
        raise FormatError(str(error), where=f"{field}.prism", fix="correct the prism") from error


def _object(record: records.ObjectRecord, field: str, trajectory: GetTrajectory) -> PhysicalObject:
    return PhysicalObject(
        record.id,
        record.labels,
        _prism(record.prism, field),
        trajectory(record.trajectory, f"{field}.trajectory"),
        record.liftable,
        record.colours,
    )


def _place(record: records.PlaceRecord, field: str) -> Place:
    return Place(_prism(record.prism, field), record.name)


def _grounding(
    record: records.GroundingRecord, field: str, here: str, world: World, trajectory: GetTrajectory
) -> Grounding:
    if isinstance(record, records.ObjectReference):
        home = record.context or here
        item = world.objects.get((home, record.object))
        if item is None:
            raise FormatError(
                f"no object {record.object!r} in the context {home!r}",
                where=field,
                fix="correct the id, or write the object out with kind 'object'",
            )
        return item
    if isinstance(record, records.ObjectGrounding):
        return _object(record, field, trajectory)
    if isinstance(record, records.PlaceGrounding):
        return _place(record, field)
    return WayGrounding(trajectory(record.trajectory, f"{field}.trajectory"))


def _words(words: tuple[records.Word, ...], text: str, field: str) -> tuple[Span, ...]:
    for i, (start, word) in enumerate(words):
        if not word or not text.startswith(word, start):
            there = text[start : start + len(word)]
            raise FormatError(
                f"the word {word!r} doesn't stand at {start} in the command, {there!r} does",
                where=f"{field}[{i}]",
                fix="give the offset of the word's first character in the command's text",
            )
    return tuple(Span(start, word) for start, word in words)


def _sdc(record: records.SDCRecord, field: str, text: str) -> SDC:
    figure, landmark1, landmark2 = (
        tuple(_sdc(child, f"{field}.{name}[{i}]", text) for i, child in enumerate(children))
        for name, children in (
            ("figure", record.figure),
            ("landmark1", record.landmark1),
            ("landmark2", record.landmark2),
        )
    )
    return SDC(
        type=record.type,
        words=_words(record.words, text, f"{field}.words"),
        relation=_words(record.relation, text, f"{field}.relation"),
        figure=figure,
        landmark1=landmark1,
        landmark2=landmark2,
    )
