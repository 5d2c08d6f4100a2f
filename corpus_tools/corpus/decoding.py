"""Conversion of the records in a corpus's files to the domain types.

Each function raises :class:`g3.errors.FormatError` whose ``where`` is the field inside
the record; :mod:`corpus_tools.corpus.corpus_reading` adds the file and the record.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import msgspec

from corpus_tools.corpus import corpus_records as records
from g3.annotation import Annotation, Command, Judgment, TaskOutcome
from g3.errors import FormatError
from g3.groundings import Context, Grounding, Path, PhysicalObject, Place, Prism, Trajectory
from g3.sdc.clauses import SDC, Span, breadth_first
from g3.short_repr import short_repr

GetTrajectory = Callable[[int, str], Trajectory]
"""The trajectory with a number; the second argument is the field that asks for it."""


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
        record.id, its_command, its_context, sdcs, groundings, record.correct, record.source
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
        found = world.objects.get((home, record.object))
        if found is None:
            raise FormatError(
                f"no object {record.object!r} in the context {home!r}",
                where=field,
                fix="correct the id, or write the object out with kind 'object'",
            )
        return found
    if isinstance(record, records.ObjectGrounding):
        return _object(record, field, trajectory)
    if isinstance(record, records.PlaceGrounding):
        return _place(record, field)
    return Path(trajectory(record.trajectory, f"{field}.trajectory"))


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
