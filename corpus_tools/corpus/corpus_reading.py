"""Reading of a corpus, with errors that name the problem, its place and its fix."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, NoReturn, TypeVar

import msgspec

from corpus_tools.corpus import decoding, digests
from corpus_tools.corpus.corpus_model import Corpus
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
from corpus_tools.corpus.encoding import Tables, content_hash
from corpus_tools.corpus.trajectory_arrays import Arrays, read_arrays, unpack_one
from corpus_tools.runtime.atomic_folder import recover
from corpus_tools.tables.json_text import explained
from g3.annotation import TaskOutcome
from g3.errors import FormatError
from g3.groundings import Trajectory
from g3.storage import regular_file
from g3.storage.text_lines import place_in

T = TypeVar("T")
R = TypeVar("R", ContextRecord, CommandRecord, AnnotationRecord, JudgmentRecord, OutcomeRecord)
OnProblem = Callable[[FormatError], None]
"""Called with each problem; where it returns, the record with the problem is left out."""


@dataclass(frozen=True, slots=True)
class _Line(Generic[R]):
    where: str
    """File, line number and id."""
    record: R


def load_corpus(path: Path | str) -> Corpus:
    """Read a corpus.

    Returns
    -------
    Corpus
        Its annotations share the instances of commands, contexts and objects.

    Raises
    ------
    FormatError
        At the first thing that is wrong.
    """
    return read_corpus(Path(path), refuse)


def refuse(problem: FormatError) -> NoReturn:
    """Raise a problem, for readers that refuse any."""
    raise problem


def read_manifest(folder: Path) -> Manifest:
    """Read corpus.json.

    Raises
    ------
    FormatError
        If the folder isn't a corpus, or one of a version that can't be read.
    """
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
        found = "none" if version is None else bytes(version).decode(errors="replace")
        raise FormatError(
            f"the format's version is {found}, this program reads 1 and 2",
            where=f"{path}: schema_version",
            fix="import the corpus again, or use the program's version that wrote it",
        )
    return _decode(content, Manifest, str(path))


def read_corpus(folder: Path, on_problem: OnProblem) -> Corpus:
    """Read a corpus, handing each problem of a record to `on_problem`.

    A corpus that can't be read at all (no corpus, a missing file) raises FormatError.
    """
    manifest = read_manifest(folder)
    corpus, tables = read_content(folder, manifest, on_problem)
    for problem in digests.problems(manifest, tables, str(folder)):
        on_problem(problem)
    return corpus


def read_content(folder: Path, manifest: Manifest, on_problem: OnProblem) -> tuple[Corpus, Tables]:
    """Read the content of a corpus, even if it differs from its manifest."""
    arrays = read_arrays(folder / TRAJECTORIES)
    trajectory = _trajectory_reader(arrays)

    def read(name: str, record_type: type[R], convert: Callable[[R], T]) -> tuple[list[R], list[T]]:
        """Read the records of a file, and convert the valid ones."""
        lines = _read_lines(folder / name, record_type, on_problem)
        return [line.record for line in lines], list(_convert(lines, convert, on_problem))

    context_records, found = read(
        CONTEXTS, ContextRecord, lambda record: decoding.context(record, trajectory)
    )
    contexts = {context.id: context for context in found}
    command_records, typed = read(COMMANDS, CommandRecord, decoding.command)
    commands = {command.id: command for command in typed}
    objects = {(c.id, item.id): item for c in found for item in c.objects}
    world = decoding.World(commands, contexts, objects)
    annotation_records, annotations = read(
        ANNOTATIONS,
        AnnotationRecord,
        lambda record: decoding.annotation(record, world, trajectory),
    )
    judgment_records, judgments = read(JUDGMENTS, JudgmentRecord, decoding.judgment)
    outcome_records, outcomes = list[OutcomeRecord](), list[TaskOutcome]()
    if manifest.counts.outcomes or (folder / OUTCOMES).exists():
        outcome_records, outcomes = read(
            OUTCOMES, OutcomeRecord, lambda record: decoding.outcome(record, world)
        )
    tables = Tables(
        context_records,
        command_records,
        annotation_records,
        judgment_records,
        arrays,
        outcome_records,
    )
    corpus = Corpus(
        name=manifest.name,
        contexts=contexts,
        commands=commands,
        annotations=tuple(annotations),
        judgments=tuple(judgments),
        source=manifest.source,
        licence=manifest.licence,
        hash=content_hash(tables),
        outcomes=tuple(outcomes),
    )
    return corpus, tables


def _trajectory_reader(arrays: Arrays) -> decoding.GetTrajectory:
    known: dict[int, Trajectory] = {}
    count = len(arrays["offsets"]) - 1

    def trajectory(index: int, field: str) -> Trajectory:
        if index >= count:
            raise FormatError(
                f"no trajectory {index}: {TRAJECTORIES} holds {count}",
                where=field,
                fix="correct the number, or restore the file",
            )
        if index not in known:
            known[index] = unpack_one(arrays, index)
        return known[index]

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
