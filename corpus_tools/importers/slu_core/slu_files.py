"""Files of a clone of slu_core: found, read, and its tables of assignments and evaluations."""

from __future__ import annotations

import bz2
import codecs
import hashlib
import hmac
import io
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

import yaml_rs

from corpus_tools.importers.report import Journal, SourceFile
from g3.annotation import Command, Judgment, Rating
from g3.errors import FormatError
from g3.short_repr import short_repr
from g3.storage import regular_file

IMPORTER = "slu-core"
SOURCE = "The authors' release of the AAAI-11 corpus, https://github.com/h2r/slu_core"
LICENCE = "The terms of h2r/slu_core apply; this toolkit's licence doesn't cover the data"

POSITIVES = "aaai11/forkliftMturkEsdcs.stefie10.groundings.withPaths.yaml"
NEGATIVES = "aaai11/corpusNegativeExamples.annotated.yaml"
EASY_NEGATIVES = "aaai11/easy_negative_objects.yaml"
SCENARIOS = "corpusCommandsForVideoSmallFilesOnly"
ASSIGNMENTS = "assignments.yaml"
EVALUATIONS = ("evaluations.yaml", "evaluations.run1.yaml")
NOT_IMPORTED = ("objects.xml", "properties.yaml")

COMPRESSED = ".bz2"
MOST_BYTES = 1 << 29
"""So large a file may be that is compressed."""


@short_repr
@dataclass(frozen=True, slots=True)
class Layout:
    """Places of the files. Names of files in messages and reports are relative to `data`."""

    data: Path
    scenarios: tuple[str, ...]


def find_layout(path: Path) -> Layout:
    """Find the data folder at `path` or in it; else raise a FormatError with the wanted files."""
    if not path.is_dir():
        raise FormatError(
            "there is no such folder",
            where=str(path),
            fix="give a clone of h2r/slu_core, or its data folder",
        )
    for data in (path, path / "data"):
        if _existing(data, POSITIVES) and (data / SCENARIOS).is_dir():
            folders = sorted(p.parent.name for p in (data / SCENARIOS).glob(f"*/{ASSIGNMENTS}"))
            if folders:
                return Layout(data, tuple(folders))
    raise FormatError(
        f"this is not slu_core: looked here and in data/ for {POSITIVES}{COMPRESSED} "
        f"(or without {COMPRESSED}) and {SCENARIOS}/*/{ASSIGNMENTS}",
        where=str(path),
        fix="give a clone of h2r/slu_core, or its data folder",
    )


def _existing(data: Path, name: str) -> str | None:
    for candidate in (name + COMPRESSED, name):
        if (data / candidate).is_file():
            return candidate
    return None


def read_text(data: Path, name: str, journal: Journal) -> str | None:
    """Read a file as text in any encoding. None if it isn't there, or can't be read.

    Text that isn't UTF-8 is read as Windows-1252; the journal notes it.
    """
    try:
        content = regular_file.read_bytes(data / name)
    except FileNotFoundError:
        journal.missing.append(name)
        return None
    except OSError as error:
        problem = f"the file can't be read: {error.strerror}"
        journal.skip(name, "", FormatError(problem, fix="check its permissions"))
        return None
    journal.files.append(SourceFile(name, hashlib.sha256(content).hexdigest(), 1))
    is_utf16 = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        return content.decode("utf-16" if is_utf16 else "utf-8-sig")
    except UnicodeDecodeError:
        journal.note("the file is not UTF-8 text; it was read as Windows-1252", name)
        return content.decode("cp1252", errors="replace")


Loaded = tuple[str, list[Any]]
"""The digest of a file, and the list in it."""


def load_records(data: Path, name: str) -> Loaded:
    """Read a file that holds a list, compressed or not. An empty file is an empty list.

    FormatError if it is damaged, or holds no list; OSError if it isn't there or can't be read.
    """
    file = _existing(data, name) or name
    content = regular_file.read_bytes(data / file)
    digest = hashlib.sha256(content).hexdigest()
    if not file.endswith(COMPRESSED):
        return digest, _parse(content)
    try:
        with bz2.open(io.BytesIO(content)) as unpacked:
            plain = unpacked.read(MOST_BYTES + 1)
    except (OSError, ValueError, EOFError) as error:
        raise FormatError(
            "the compressed file is damaged or cut off", fix="fetch the file again"
        ) from error
    if len(plain) > MOST_BYTES:
        raise FormatError(
            f"the compressed file holds more than {MOST_BYTES} bytes", fix="fetch the file again"
        )
    return digest, _parse(plain)


def read_records(
    layout: Layout, name: str, journal: Journal, ahead: Future[Loaded] | None = None
) -> tuple[str, list[Any]]:
    """Read a file that holds a list, and note the result in the journal.

    `ahead` is what :func:`load_records` makes of it, where another thread does that meanwhile.
    Returns the file's name as found, and the list: empty if the file is missing, empty or can't be
    read, which the journal notes.
    """
    file = _existing(layout.data, name)
    if file is None:
        journal.missing.append(name)
        return name, []
    try:
        digest, records = load_records(layout.data, name) if ahead is None else ahead.result()
    except FormatError as error:
        journal.skip(file, "", error)
        return file, []
    except OSError as error:
        problem = f"the file can't be read: {error.strerror}"
        journal.skip(file, "", FormatError(problem, fix="check its permissions"))
        return file, []
    journal.files.append(SourceFile(file, digest, len(records)))
    return file, records


def _parse(content: bytes) -> list[Any]:
    fix = "fetch the file again"
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise FormatError(f"the file is not UTF-8 text: {error}", fix=fix) from error
    value = parse_yaml(text)
    if value is None:
        return []
    if not isinstance(value, list):
        raise FormatError(f"the file holds a {type(value).__name__}, not a list", fix=fix)
    return value


def parse_yaml(text: str) -> Any:
    """Parse YAML; FormatError if it isn't YAML."""
    try:
        return yaml_rs.loads(text)
    except yaml_rs.YAMLDecodeError as error:
        first_line, *_ = str(error).splitlines()
        problem = f"the file is not valid: {first_line}"
        raise FormatError(problem, fix="fetch the file again") from error


HASH_LENGTH = 12


def hash_subject(worker: object, salt: str) -> str:
    """Hash a worker's id: the same for the same worker and salt, and irreversible."""
    if not worker:
        return ""
    digest = hmac.new(salt.encode(), str(worker).encode(), hashlib.sha256)
    return digest.hexdigest()[:HASH_LENGTH]


def read_assignments(
    layout: Layout, scenario: str, salt: str, journal: Journal
) -> dict[str, Command]:
    """Read the commands typed for a scenario, by assignment.

    A command's id is the scenario and its number in the file, such as
    ``move_tire_pallet-03``.
    """
    commands: dict[str, Command] = {}
    file, records = read_records(layout, f"{SCENARIOS}/{scenario}/{ASSIGNMENTS}", journal)
    for number, record in enumerate(records, start=1):
        try:
            assignment, text, video = _fields(record, "assignmentId", "command", "youtubeId")
            if assignment in commands:
                raise FormatError(
                    f"the assignment {assignment} occurs twice",
                    where="assignmentId",
                    fix="remove one of them",
                )
        except FormatError as error:
            journal.skip(file, f"record {number}", error)
            continue
        name = f"{scenario}-{number:02}"
        if not text.strip():
            journal.note("nothing was typed", name)
        commands[assignment] = Command(
            id=name,
            text=text,
            scenario=scenario,
            video=video,
            subject=hash_subject(record.get("workerId"), salt),
        )
    return commands


def read_judgments(layout: Layout, scenario: str, salt: str, journal: Journal) -> list[Judgment]:
    """Read the judgments of a scenario's commands; a study is named after its file."""
    judgments: list[Judgment] = []
    for name in EVALUATIONS:
        study = name.removesuffix(".yaml")
        file, records = read_records(layout, f"{SCENARIOS}/{scenario}/{name}", journal)
        for number, record in enumerate(records, start=1):
            try:
                judgment = _judgment(record, f"{scenario}/{study}-{number:03}", study, salt)
            except FormatError as error:
                journal.skip(file, f"record {number}", error)
                continue
            judgments.append(judgment)
    return judgments


def _judgment(record: Any, name: str, study: str, salt: str) -> Judgment:
    command, command_video, shown_video = _fields(
        record, "command", "commandYoutubeId", "displayedYoutubeId"
    )
    return Judgment(
        id=name,
        command=command,
        command_video=command_video,
        shown_video=shown_video,
        rating=_rating(record.get("similarityScore")),
        subject=hash_subject(record.get("workerId"), salt),
        study=study,
    )


def _rating(value: object) -> Rating:
    ratings: tuple[Rating, ...] = get_args(Rating)
    for rating in ratings:
        if value == rating:
            return rating
    raise FormatError(
        f"{value!r} is not a rating",
        where="similarityScore",
        fix=f"use one of {', '.join(ratings)}",
    )


def _fields(record: Any, *names: str) -> list[str]:
    if not isinstance(record, dict):
        raise FormatError("this is not a mapping", fix=f"it needs {', '.join(names)}")
    for name in names:
        if not isinstance(record.get(name), str | int):
            raise FormatError("the value is missing", where=name, fix="add it")
    return [str(record[name]) for name in names]
