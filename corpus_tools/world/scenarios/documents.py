"""YAML whose every value knows its line.

The values are those of YAML 1.2's core schema: ``yes``, ``on`` and ``1:30`` are text.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import msgspec
import yaml

from g3.errors import FormatError
from g3.short_repr import short_repr
from g3.storage import regular_file
from g3.storage.text_lines import decode_text, place_in

Field: TypeAlias = tuple[str | int, ...]
"""Keys and indices that lead to a value from the top of a document."""

T = TypeVar("T")

_Loader = getattr(yaml, "CBaseLoader", yaml.BaseLoader)
_NULL = {"", "~", "null", "Null", "NULL"}
_TRUE, _FALSE = {"true", "True", "TRUE"}, {"false", "False", "FALSE"}
_INTEGER = re.compile(r"[-+]?[0-9]+")
_NUMBER = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_LONGEST_NUMBER = 40
_DEEPEST = 20
_OTHER_LINE_ENDS = "\x85\u2028\u2029"
_PRIVATE_USE = range(0x10FF00, 0x10FFFE)
_MOST_BYTES = 1 << 24
_OWN_WORDS = {
    "array": "a list",
    "object": "fields",
    "str": "text",
    "float": "a number",
    "int": "a whole number",
    "null": "nothing",
    "bool": "true or false",
}
"""Plain names of msgspec's types."""
_OWN_FORMS = {
    r"^[a-z0-9][a-z0-9-]*$": "of small letters, digits and hyphens, such as my-study",
    r"^[a-z]{2,3}(-[A-Za-z]+)*$": "that names a language, such as de",
    r"^[A-Z]{3}$": "of three letters, such as EUR",
    r"\S": "that isn't empty",
}
"""Plain words for patterns of texts."""
_CODES_OF_LIMITS = {
    ("str", "of length >="): "too-short",
    ("array", "of length >="): "too-short",
    ("str", "of length <="): "too-long",
    **{(kind, ">="): "below" for kind in ("int", "float")},
    **{(kind, ">"): "not-above" for kind in ("int", "float")},
    **{(kind, "<="): "above" for kind in ("int", "float")},
}
"""Codes of problems, by msgspec's type and relation."""


@short_repr
@dataclass(frozen=True, slots=True)
class Problem:
    """Something in a document that can't be so."""

    field: Field
    """Field that it is about."""
    what: str
    fix: str
    """Problem and way to fix it, as in :class:`g3.errors.CorpusError`."""
    code: str = ""
    """Name of the kind of problem, for pages with words of their own; empty for most."""
    limit: str = ""
    """Limit that a value is beyond."""


@short_repr
@dataclass(frozen=True, slots=True)
class Document:
    """A YAML file as it was read."""

    name: str
    """The file, as errors name it."""
    content: bytes
    value: Any
    """Plain dictionaries, lists, text, numbers, booleans and None."""
    marks: Mapping[Field, tuple[int, int]]
    """Line and column of every value, from 1."""
    keys: Mapping[Field, tuple[int, int]]
    """Line and column of every key."""

    def error(self, problem: Problem) -> FormatError:
        """Return the error with a problem's file, line, column and field."""
        path = problem.field
        while path not in self.marks and path:
            path = path[:-1]
        mark = self.marks.get(path, (1, 1))
        # What is wrong with something that has a name of its own is reported where the name is.
        if isinstance(self._at(path), dict) or problem.field != path:
            mark = self.keys.get(path, mark)
        place = ":".join((self.name, *map(str, mark)))
        field = field_name(problem.field)
        return FormatError(
            problem.what, where=f"{place}: {field}" if field else place, fix=problem.fix
        )

    def _at(self, field: Field) -> Any:
        value = self.value
        for key in field:
            value = value[key]
        return value


def field_name(field: Field) -> str:
    """Return a field as people write it, such as ``commands[2].text``."""
    parts = (f"[{key}]" if isinstance(key, int) else f".{key}" for key in field)
    return "".join(parts).removeprefix(".")


def read_document(path: Path, name: str | None = None) -> Document:
    """Read a file, which errors call `name`, or its path if none is given.

    FormatError if it can't be read or is no YAML.
    """
    shown = str(path) if name is None else name
    try:
        content = regular_file.read_bytes(path, most=_MOST_BYTES)
        return parse_document(content, shown)
    except OSError as error:
        raise FormatError(
            f"the file can't be read: {error.strerror}",
            where=shown,
            fix="check its name and its permissions",
        ) from error


def parse_document(content: bytes, name: str) -> Document:
    """Parse the bytes of a file; FormatError for no YAML, for tags, aliases or a key twice."""
    text = decode_text(content, name)
    stand_ins = _stand_ins(text)
    try:
        events = yaml.parse(text.translate(stand_ins), Loader=_Loader)
        reader = _Reader(name, events, {ord(new): chr(old) for old, new in stand_ins.items()})
        value = reader.document()
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        at = (mark.line + 1, mark.column + 1) if mark else place_in(text, _offset(error))
        where = ":".join((name, *map(str, at)))
        what = getattr(error, "problem", None) or str(error).splitlines()[0]
        raise FormatError(f"this is not YAML: {what}", where=where, fix="correct it") from error
    return Document(name, content, value, reader.marks, reader.keys)


def _stand_ins(text: str) -> dict[int, str]:
    """Return characters that a text lacks, for those that end lines only in YAML 1.1.

    So they stay what they are, and lines have the numbers that editors show.
    """
    line_ends = [end for end in _OTHER_LINE_ENDS if end in text]
    free = (chr(code) for code in _PRIVATE_USE if chr(code) not in text)
    return {ord(end): next(free) for end in line_ends}


def _offset(error: yaml.YAMLError) -> int:
    """Return the position of a character that YAML doesn't allow."""
    return getattr(error, "position", None) or 0


def convert(
    value: Any, record_type: type[T], field: Field, manual: str = "docs/scenarios.md"
) -> T | Problem:
    """Return a value as a record, of a type that :func:`msgspec.convert` knows, or the problem.

    `field` is where in the document the value is; `manual` describes the form that it should have.
    """
    try:
        return msgspec.convert(value, record_type)
    except msgspec.ValidationError as error:
        # msgspec ends its message with the field: "... - at `$.at[0]`"
        match = re.fullmatch(r"(?s)(.*?)(?: - at `(?:key in )?\$(.*)`)?", str(error))
        what, inner = (match[1], match[2] or "") if match else (str(error), "")
        keys = re.findall(r"\.([^.\[\]]+)|\[([0-9]+)\]", inner)
        where = (*field, *(key or int(index) for key, index in keys))
        unknown = re.fullmatch(r"Object contains unknown field `(.*)`", what)
        if unknown:
            return Problem((*where, unknown[1]), "there is no such field", "leave it out")
        return Problem(where, _reworded(what), f"see {manual} for the form", *_code(what))


def _code(what: str) -> tuple[str, str]:
    """Return the code and the limit of msgspec's message; empty if there is no code for it."""
    limits = r"(?: (of length >=|of length <=|>=|>|<=) (.+)|, got .+)?"
    match = re.fullmatch(r"Expected `(\w+)(?: \| null)?`" + limits, what)
    if match is None:
        return "", ""
    kind, relation, limit = match[1], match[2] or "", match[3] or ""
    if relation:
        return _CODES_OF_LIMITS.get((kind, relation), ""), limit
    return {"int": "no-integer", "float": "no-number"}.get(kind, ""), ""


def _reworded(what: str) -> str:
    missing = re.fullmatch(r"Object missing required field `(.*)`", what)
    if missing:
        return f"the field {missing[1]!r} is missing"
    what = re.sub(r"Invalid enum value ('.*')", r"\1 is none of the choices", what)
    what = re.sub(r"`array` of length ([0-9]+)", r"\1 numbers", what)
    what = re.sub(r"`([a-z]+(?: \| [a-z]+)*)`", lambda types: _own_words(types[1]), what)
    for pattern, words in _OWN_FORMS.items():
        what = what.replace(f"matching regex {pattern!r}", words)
    return what[:1].lower() + what[1:]


def _own_words(types: str) -> str:
    names = types.removesuffix(" | null").split(" | ")
    return " or ".join(_OWN_WORDS.get(name, name) for name in names)


class _Reader:
    """Turns a parser's events into values and remembers where they were."""

    def __init__(self, name: str, events: Iterator[Any], meant: Mapping[int, str]) -> None:
        self.name = name
        self.events = events
        self.meant = meant
        self.marks: dict[Field, tuple[int, int]] = {}
        self.keys: dict[Field, tuple[int, int]] = {}

    def document(self) -> Any:
        """Return the only document; None if there is none."""
        next(self.events)
        if isinstance(next(self.events), yaml.StreamEndEvent):
            return None
        value = self.value(next(self.events), ())
        next(self.events)
        after = next(self.events)
        if not isinstance(after, yaml.StreamEndEvent):
            raise self.refusal(after, (), "this is a second document", "leave it out")
        return value

    def value(self, event: Any, field: Field) -> Any:
        self.marks[field] = _mark(event)
        if isinstance(event, yaml.AliasEvent):
            raise self.refusal(event, field, "aliases aren't understood", "write the value again")
        if event.tag is not None:
            raise self.refusal(
                event, field, f"the tag {event.tag} isn't understood", "leave it out"
            )
        if len(field) > _DEEPEST:
            raise self.refusal(event, (), "this is nested too deeply", "correct it")
        if isinstance(event, yaml.MappingStartEvent):
            return dict(self.entry(key, field) for key in self.until(yaml.MappingEndEvent))
        if isinstance(event, yaml.SequenceStartEvent):
            items = enumerate(self.until(yaml.SequenceEndEvent))
            return [self.value(item, (*field, i)) for i, item in items]
        return self.scalar(event, field)

    def until(self, end: type) -> Iterator[Any]:
        while not isinstance(event := next(self.events), end):
            yield event

    def entry(self, key: Any, field: Field) -> tuple[str, Any]:
        if not isinstance(key, yaml.ScalarEvent):
            raise self.refusal(key, field, "a key must be text", "correct it")
        name = str(key.value).translate(self.meant)
        inner = (*field, name)
        if inner in self.keys:
            raise self.refusal(key, inner, "this is given twice", "leave one of them out")
        self.keys[inner] = _mark(key)
        return name, self.value(next(self.events), inner)

    def scalar(self, event: Any, field: Field) -> Any:
        text: str = event.value.translate(self.meant)
        if event.style:
            return text
        if text in _NULL:
            return None
        if text in _TRUE or text in _FALSE:
            return text in _TRUE
        if len(text) > _LONGEST_NUMBER or not _NUMBER.fullmatch(text):
            return text
        number = int(text) if _INTEGER.fullmatch(text) else float(text)
        if number in (float("inf"), float("-inf")):
            raise self.refusal(event, field, "the number is too large", "correct it")
        return number

    def refusal(self, event: Any, field: Field, what: str, fix: str) -> FormatError:
        mark = ":".join(map(str, _mark(event)))
        where = ": ".join(part for part in (f"{self.name}:{mark}", field_name(field)) if part)
        return FormatError(what, where=where, fix=fix)


def _mark(event: Any) -> tuple[int, int]:
    return event.start_mark.line + 1, event.start_mark.column + 1
