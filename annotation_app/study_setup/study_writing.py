"""Writing a study's file, which keeps what was there before."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import msgspec
import yaml

from annotation_app.studies.study_file import StudyConfig
from corpus_tools.world.scenarios.documents import parse_document
from g3.errors import FormatError
from g3.storage.atomic_file import write_bytes

HEADER = "# A study, as it was written in the browser. docs/annotation.md lists all fields.\n"
OLD_VERSIONS = "versions"
"""Folder beside study files, of what they were before."""
_PLAIN = re.compile(r"[A-Za-z][\w ,.'!?()/-]*[\w.!?)]")
_NOT_TEXT = {"null", "true", "false"}
_WIDTH = 100


def to_yaml(value: Mapping[str, Any]) -> bytes:
    """A study as a file that :func:`~annotation_app.study_setup.study_reading.read_study` reads."""
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
    """A study with its fields in the order of the docs."""
    names = [known.encode_name for known in msgspec.structs.fields(StudyConfig)]
    return {name: value[name] for name in (*names, *value) if name in value}


def write_study(file: Path, value: Mapping[str, Any]) -> str:
    """Write a study's file; the name of the copy of what was there, empty if nothing was.

    Raises
    ------
    FormatError
        If it can't be written.
    """
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
        raise FormatError(
            f"the study's file can't be written: {error.strerror}",
            where=str(file),
            fix="let the program that serves the app write there",
        ) from error
    return kept


def comments(content: bytes) -> list[str]:
    """The comments in a study's file, without the one that this program writes.

    Raises
    ------
    FormatError
        If it is no YAML.
    """
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
    if "\n" in text and not any(_trailing(text)):
        style = "|"
    elif _PLAIN.fullmatch(text) and text.casefold() not in _NOT_TEXT:
        style = ""
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style or None)


def _trailing(text: str) -> Iterator[bool]:
    """Whether lines end or the text begins with a space: a block of lines would lose it."""
    yield text[:1].isspace()
    yield from (line != line.rstrip() for line in text.split("\n"))


_Dumper.add_representer(str, _text)
_Dumper.add_representer(tuple, yaml.SafeDumper.represent_list)
