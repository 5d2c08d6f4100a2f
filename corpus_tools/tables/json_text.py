"""JSON and JSON lines, read strictly: a name that is there twice is an error, not the last value.

Errors have the line and the column of what is wrong, which msgspec doesn't give.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from g3.errors import FormatError
from g3.storage import regular_file
from g3.storage.text_lines import decode_text, place_in, split_lines

T = TypeVar("T")

_SPACE = re.compile(r"[ \t\r\n]*")
_DECODER = json.JSONDecoder(parse_int=str, parse_float=str)
_HALF_PAIR = re.compile(r"\\u[dD][89abAB][0-9a-fA-F]{2}(?!\\u[dD][c-fC-F])|\\u[dD][c-fC-F]")


def read_text(path: Path, *, what: str = "file", fix: str = "give another file") -> str:
    """Return the text of a UTF-8 file."""
    try:
        content = regular_file.read_bytes(path)
    except OSError as error:
        raise FormatError(
            f"the {what} can't be read: {error.strerror}", where=str(path), fix=fix
        ) from error
    return decode_text(content, str(path))


def read_json(path: Path, kind: type[T], *, what: str, fix: str) -> T:
    """Read a JSON file as a record.

    Parameters
    ----------
    kind
        The record's type, as msgspec takes it.
    what
        The sort of file, as errors name it, such as "COCO file".
    fix
        The remedy in errors.
    """
    try:
        return decode(read_text(path), msgspec.json.Decoder(kind), str(path), fix=fix)
    except FormatError as error:
        if "can't be read" in error.what:
            raise
        raise FormatError(f"this is no {what}: {error.what}", where=error.where, fix=fix) from error


def json_lines(path: Path, kind: type[T], *, fix: str) -> Iterator[tuple[int, T]]:
    """Read a file of JSON lines: the number of each line that isn't blank, and its record.

    Lines end at line feeds only. `kind` and `fix` are those of :func:`read_json`.
    """
    decoder = msgspec.json.Decoder(kind)
    for number, line in numbered_lines(read_text(path, fix=fix)):
        yield number, decode(line, decoder, str(path), number, fix=fix)


def numbered_lines(text: str) -> Iterator[tuple[int, str]]:
    """Return the lines of a text that aren't blank, with their numbers from 1."""
    for number, line in enumerate(split_lines(text), start=1):
        if line.strip(" \t\r"):
            yield number, line


def decode(
    text: str, decoder: msgspec.json.Decoder[T], where: str, line: int | None = None, *, fix: str
) -> T:
    """Decode JSON.

    Parameters
    ----------
    text
        A whole file, or one line of it.
    where
        The file, as errors name it.
    line
        The number of the line, if it is one.
    fix
        The remedy in errors.
    """
    try:
        record = decoder.decode(text)
        json.loads(text, object_pairs_hook=_object, parse_int=str, parse_float=str)
    except (msgspec.DecodeError, RecursionError, ValueError) as error:
        what, field, offset = explained(error, text)
        row, column = place_in(text, offset) if line is None else (line, offset + 1)
        place = f"{where}:{row}:{column}"
        raise FormatError(what, where=f"{place}: {field}" if field else place, fix=fix) from error
    return record


class _RepeatedNameError(ValueError):
    """An object has a name twice."""


def _object(pairs: list[tuple[str, Any]]) -> None:
    if len({name for name, _ in pairs}) < len(pairs):
        raise _RepeatedNameError


def explained(error: Exception, text: str) -> tuple[str, str, int]:
    """Return the problem of a JSON text, the field that it is in, and its place.

    Parameters
    ----------
    error
        An error of msgspec, or of :func:`decode`.

    Returns
    -------
    what, field, offset
        The field is empty if the error is in none; the offset counts characters.
    """
    if isinstance(error, msgspec.ValidationError):
        # msgspec ends its message with the field: "... - at `$.objects[0].id`"
        match = re.fullmatch(r"(?s)(.*?)(?: - at `(?:key in )?\$\.?(.*)`)?", str(error))
        what, field = (match[1], match[2] or "") if match else (str(error), "")
        return what[:1].lower() + what[1:], field, _offset_of(text, field)
    if isinstance(error, _RepeatedNameError):
        field, offset = _repeated_name(text)
        return "this name is in the object already", field, offset
    if isinstance(error, RecursionError):
        return "the JSON is nested too deeply", "", 0
    try:
        json.loads(text, parse_constant=_refuse_constant)
    except json.JSONDecodeError as place:
        return f"JSON is malformed: {place.msg[:1].lower()}{place.msg[1:]}", "", place.pos
    except (ValueError, RecursionError):
        pass
    half = _HALF_PAIR.search(text)
    if half:
        return f"{half[0]} is half of a character", "", half.start()
    at = re.search(r" \(byte ([0-9]+)\)", str(error))
    before = text.encode()[: int(at[1])].decode(errors="ignore") if at else ""
    return str(error).replace(at[0] if at else "", ""), "", len(before)


def _refuse_constant(name: str) -> None:
    raise ValueError(name)


def _offset_of(text: str, field: str) -> int:
    """Return the place of a field, or of the innermost existing one around it."""
    around = {0: 0}  # offsets by the lengths of names
    try:
        for name, offset, _ in _fields(text):
            if name == field:
                return offset
            if field.startswith((f"{name}.", f"{name}[")):
                around[len(name)] = offset
    except (ValueError, IndexError):
        pass  # the text is cut off after the error
    return around[max(around)]


def _repeated_name(text: str) -> tuple[str, int]:
    return next((name, offset) for name, offset, again in _fields(text) if again)


def _fields(text: str) -> Iterator[tuple[str, int, bool]]:
    """Yield the fields of a well-formed text, each with its value's place and if it is repeated.

    The place of a repeated one is that of its name.
    """
    stack: list[tuple[str, set[str] | None, int]] = []  # the name, an object's names, an index
    at, name = _skip(text, 0), ""
    while True:
        yield name, at, False
        if text[at] in "{[":
            stack.append((name, set() if text[at] == "{" else None, 0))
            at = _skip(text, at + 1)
        else:
            at = _skip(text, _DECODER.raw_decode(text, at)[1])
        while stack and text[at] in "}]":
            stack.pop()
            at = _skip(text, at + 1)
        if not stack:
            return
        if text[at] == ",":
            at = _skip(text, at + 1)
        outer, names, index = stack.pop()
        if names is None:
            name = f"{outer}[{index}]"
        else:
            key, end = _DECODER.raw_decode(text, at)
            name = f"{outer}.{key}".removeprefix(".")
            if key in names:
                yield name, at, True
            names.add(key)
            at = _skip(text, _skip(text, end) + 1)
        stack.append((outer, names, index + 1))


def _skip(text: str, at: int) -> int:
    match = _SPACE.match(text, at)
    return at if match is None else match.end()
