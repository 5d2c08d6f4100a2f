"""Studies that somebody is at work on in the browser, until they are written to their file.

A draft is a JSON file in the folder of studies. It has what the study's file will say, which keeps
what was there before.
"""

from __future__ import annotations

import hashlib
import re
import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import msgspec
import yaml

from annotation_app.studies.study_file import Name, StudyConfig
from corpus_tools.world.scenarios.documents import parse_document, read_document
from g3.errors import FormatError
from g3.storage.atomic_file import write_bytes

FOLDER = ".drafts"
HEADER = "# A study, as it was written in the browser. docs/annotation.md lists all fields.\n"
OLD_VERSIONS = "versions"
"""Folder beside study files, of what they were before."""
_PLAIN = re.compile(r"[A-Za-z][\w ,.'!?()/-]*[\w.!?)]")
_NOT_TEXT = {"null", "true", "false"}
_WIDTH = 100


@dataclass(frozen=True, slots=True)
class StudyDraft:
    """A study that somebody is at work on."""

    name: str
    """The study's."""
    file: Path
    """Path of the study's file, present or future."""
    value: dict[str, Any] = field(default_factory=dict)
    """Future content of the file."""
    base: str = ""
    """SHA-256 of the file when the draft was begun; empty for a new study."""

    @property
    def is_new(self) -> bool:
        """True if there is no such study yet."""
        return not self.base


class _Kept(msgspec.Struct, frozen=True):
    file: str
    value: dict[str, Any]
    base: str


def is_name(name: str) -> bool:
    """Check that a study may have this name."""
    try:
        msgspec.convert(name, Name)
    except msgspec.ValidationError:
        return False
    return True


def begun(file: Path, name: str) -> StudyDraft:
    """Return a draft of the study that a file describes; raise if that can't be read."""
    document = read_document(file)
    if not isinstance(document.value, dict):
        raise FormatError("this is no study", where=str(file), fix="correct the file")
    return StudyDraft(name, file, document.value, sha256_of(file))


def find_draft(folder: Path, name: str) -> StudyDraft | None:
    """Return the draft of a study, if there is one."""
    path = _path(folder, name)
    try:
        kept = msgspec.json.decode(path.read_bytes(), type=_Kept)
    except OSError:
        return None
    except msgspec.DecodeError as error:
        raise FormatError(
            "this draft of a study can't be read", where=str(path), fix="delete it"
        ) from error
    return StudyDraft(name, Path(kept.file), kept.value, kept.base)


def drafts(folder: Path) -> list[str]:
    """Return the names of the studies with a draft."""
    return sorted(path.stem for path in (folder / FOLDER).glob("*.json"))


def keep_draft(folder: Path, draft: StudyDraft, value: dict[str, Any]) -> StudyDraft:
    """Keep a draft's present value; raise if it can't be written."""
    path = _path(folder, draft.name)
    kept = _Kept(str(draft.file), value, draft.base)
    try:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        write_bytes(path, msgspec.json.encode(kept))
    except OSError as error:
        raise _unwritable("the draft", path, error) from error
    return replace(draft, value=value)


def drop_draft(folder: Path, name: str) -> None:
    """Forget a draft."""
    _path(folder, name).unlink(missing_ok=True)


def sha256_of(file: Path) -> str:
    """Return the digest of a file's content; empty if there is no file."""
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError:
        return ""


def _path(folder: Path, name: str) -> Path:
    assert is_name(name)  # noqa: S101 - no other comes here, and none may lead elsewhere
    return folder / FOLDER / f"{name}.json"


def to_yaml(value: Mapping[str, Any]) -> bytes:
    """Return a study's file, for :func:`~annotation_app.study_setup.study_reading.read_study`."""
    text = yaml.dump(
        dict(value),
        Dumper=_Dumper,
        sort_keys=False,
        allow_unicode=True,
        width=_WIDTH,
        default_flow_style=False,
    )
    return f"{HEADER}{text}".encode()


def in_order(value: Mapping[str, Any]) -> dict[str, Any]:
    """Return a study with its fields in the order of the docs."""
    names = [known.encode_name for known in msgspec.structs.fields(StudyConfig)]
    return {name: value[name] for name in (*names, *value) if name in value}


def write_study(file: Path, value: Mapping[str, Any]) -> str:
    """Write a study's file; the name of the copy of what was there, empty if nothing was."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        kept = ""
        if file.is_file():
            folder = file.parent / OLD_VERSIONS
            folder.mkdir(exist_ok=True)
            before = file.read_bytes()
            kept = f"{file.stem}-{time.strftime('%Y%m%dT%H%M%SZ', time.gmtime())}{file.suffix}"
            write_bytes(folder / kept, before)
        write_bytes(file, to_yaml(value))
    except OSError as error:
        raise _unwritable("the study's file", file, error) from error
    return kept


def _unwritable(what: str, path: Path, error: OSError) -> FormatError:
    fix = "let the program that serves the app write there"
    return FormatError(f"{what} can't be written: {error.strerror}", where=str(path), fix=fix)


def comments(content: bytes) -> list[str]:
    """Return a study file's comments, but not this program's; FormatError if it is no YAML."""
    parse_document(content, "the study's file")
    text = content.decode()
    values = [
        (event.start_mark.index, event.end_mark.index)
        for event in yaml.parse(text, Loader=yaml.SafeLoader)
        if isinstance(event, yaml.ScalarEvent) and event.start_mark and event.end_mark
    ]
    found = []
    for match in re.finditer(r"(?m)(?:^|(?<=\s))#.*$", text):
        in_value = any(start <= match.start() < end for start, end in values)
        if not in_value and match[0] != HEADER.strip():
            found.append(match[0])
    return found


class _Dumper(yaml.SafeDumper):
    """Writes text so that no reader takes it for a number: of several lines as it is read."""

    def increase_indent(self, flow: bool = False, indentless: bool = False) -> None:
        super().increase_indent(flow, indentless=False)


def _text(dumper: yaml.SafeDumper, text: str) -> yaml.ScalarNode:
    style = '"'
    # A block of lines would lose spaces at the text's beginning and at the ends of lines.
    is_lost = text[:1].isspace() or any(line != line.rstrip() for line in text.split("\n"))
    if "\n" in text and not is_lost:
        style = "|"
    elif _PLAIN.fullmatch(text) and text.casefold() not in _NOT_TEXT:
        style = ""
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style or None)


_Dumper.add_representer(str, _text)
_Dumper.add_representer(tuple, yaml.SafeDumper.represent_list)
