"""SDC trees as text: the bracket notation of the paper's Figures 2a and 3a, and JSON.

``EVENT_1(r = Put, l = OBJ_2(f = the pallet), l2 = PLACE_3(r = on, l = OBJ_4(f = the truck)))``

As in the figures, the implicit figure of an imperative (the robot) is left out: an EVENT
without ``f`` has it, and an EVENT that truly has no figure says ``f = []``. The whole
notation is described in ``docs/sdc-notation.md``.
"""

from __future__ import annotations

import json
import re
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple, get_args

from g3.errors import SDCError
from g3.lengths import MAX_NOTATION, check_length
from g3.sdc.clauses import CHILD_FIELDS, SDC, SDC_TYPES, Field, SDCType, Span
from g3.sdc.word_alignment import FieldWord, align_words

MAX_DEPTH = 64
"""Largest depth of nested clauses; the deepest of the paper's corpus has five levels."""

BARE_WORD = re.compile(r"[^\s,;()\[\]=@\"]+")

_TYPES: dict[str, SDCType] = {
    "EVENT": "EVENT",
    "OBJ": "OBJECT",
    "OBJECT": "OBJECT",
    "PLACE": "PLACE",
    "PATH": "PATH",
}
_FIELDS: dict[str, Field] = {
    "f": "f",
    "r": "r",
    "l": "l",
    "l1": "l",
    "l_1": "l",
    "l2": "l2",
    "l_2": "l2",
}
_HEAD = re.compile(rf"({'|'.join(_TYPES)})(?:_?[0-9]+)?")
_TOKEN = re.compile(
    rf"""
    (?P<separator> [\n\r;] ) |
    (?P<space> \s ) |
    (?P<mark> [(),\[\]=] ) |
    (?P<position> @[0-9]{{1,18}}(?![0-9]) ) |
    (?P<quoted> "(?:[^"\\]|\\.)*" ) |
    (?P<bare> {BARE_WORD.pattern} )
    """,
    re.VERBOSE,
)


class _Draft(NamedTuple):
    """A clause as it was written.

    Parameters
    ----------
    children
        The clauses of the fields that hold clauses, or nothing (``f = []``).
    """

    type: SDCType
    words: dict[Field, list[FieldWord]]
    children: dict[Field, list[_Draft]]


class _Token(NamedTuple):
    kind: str
    text: str
    offset: int


def is_word(text: str) -> bool:
    """Check that a text is one word: not empty and without white space."""
    return bool(text) and not any(character.isspace() for character in text)


def _read_clauses(notation: str) -> list[_Draft]:
    """Read the top-level clauses of a notation.

    Raises
    ------
    SDCError
        If it is longer than :data:`g3.lengths.MAX_NOTATION`; where it leaves the grammar, with
        line, column and what was expected.
    """
    check_length(notation, MAX_NOTATION, error=SDCError)
    reader = _Reader(notation)
    drafts: list[_Draft] = []
    while True:
        separated = not drafts
        while reader.skip("separator"):
            separated = True
        if reader.skip("end"):
            return drafts
        if not separated:
            raise reader.unexpected("a new line or ';' between clauses")
        drafts.append(reader.clause())


def _tokens(notation: str) -> Iterator[_Token]:
    """Split a notation; line breaks separate clauses only outside of all brackets."""
    offset = 0
    brackets = 0
    while offset < len(notation):
        match = _TOKEN.match(notation, offset)
        if match is None:
            kind, text = "bad", notation[offset]
        else:
            kind, text = str(match.lastgroup), match.group()
        if text in ("(", "["):
            brackets += 1
        elif text in (")", "]"):
            brackets -= 1
        broken_line = kind == "separator" and text != ";" and brackets > 0
        if kind != "space" and not broken_line:
            yield _Token(kind, text, offset)
        offset += len(text)
        if kind == "bad":  # which no clause has: the reader goes no further
            break
    yield _Token("end", "", offset)


class _Reader:
    """Recursive descent; its state is how far it has come in the tokens."""

    def __init__(self, notation: str) -> None:
        self._line_starts = [0, *(i + 1 for i, c in enumerate(notation) if c == "\n")]
        self._tokens = list(_tokens(notation))
        self._index = 0

    @property
    def _next(self) -> _Token:
        return self._tokens[self._index]

    def _take(self) -> _Token:
        token = self._next
        if token.kind != "end":
            self._index += 1
        return token

    def skip(self, kind: str, text: str = "") -> bool:
        """Take the next token if it is of a kind (and has a text); say whether it was."""
        matches = self._next.kind == kind and text in ("", self._next.text)
        if matches:
            self._take()
        return matches

    def _where(self, offset: int) -> str:
        line = bisect_right(self._line_starts, offset)
        column = offset - self._line_starts[line - 1] + 1
        return f"line {line}, column {column}" if line > 1 else f"column {column}"

    def unexpected(self, expected: str, fix: str = "") -> SDCError:
        """Return the error for a token that isn't ``expected``."""
        token = self._next
        shown = "the notation ends" if token.kind == "end" else f"found {token.text!r}"
        if token.text == '"':
            fix = "the quoted word has no end"
        elif token.text == "@":
            fix = "a position is '@' and at most 18 digits, right after its word"
        elif token.text in ("(", "["):
            fix = "quote a word that holds a bracket"
        return SDCError(
            f"expected {expected}, but {shown}", where=self._where(token.offset), fix=fix
        )

    def clause(self, depth: int = 1) -> _Draft:
        """Read one clause, from its type to its closing bracket."""
        start = self._next.offset
        head = _HEAD.fullmatch(self._next.text) if self._next.kind == "bare" else None
        if head is None:
            fix = "such as OBJ(f = the pallet); `ct parse` makes clauses of a text"
            raise self.unexpected("a clause", fix=fix)
        if depth > MAX_DEPTH:
            raise SDCError(f"clauses nest deeper than {MAX_DEPTH} levels", where=self._where(start))
        self._take()
        if not self.skip("mark", "("):
            raise self.unexpected(f"'(' after {head.group()}")
        draft = _Draft(_TYPES[head.group(1)], {}, {})
        if not self.skip("mark", ")"):
            self._field(draft, depth)
            while self.skip("mark", ","):
                self._field(draft, depth)
            if not self.skip("mark", ")"):
                raise self.unexpected("',' or ')'")
        if "f" in draft.words and (len(draft.words) > 1 or any(draft.children.values())):
            raise SDCError(
                "the figure holds words though other fields are filled",
                where=self._where(start),
                fix="write the figure as a clause, such as f = OBJ(f = the pallet)",
            )
        return draft

    def _field(self, draft: _Draft, depth: int) -> None:
        field = _FIELDS.get(self._next.text)
        if field is None:
            raise self.unexpected("a field: f, r, l or l2")
        if field in draft.words or field in draft.children:
            raise SDCError(
                f"the field {field} is given twice", where=self._where(self._next.offset)
            )
        name = self._take().text
        if not self.skip("mark", "="):
            raise self.unexpected(f"'=' after {name}")
        if self._at_clause():
            if field == "r":
                raise self.unexpected("words in the relation field")
            draft.children[field] = [self.clause(depth + 1)]
        elif self.skip("mark", "["):
            draft.children[field] = self._list(field, depth)
        elif field in ("l", "l2"):
            raise self.unexpected(
                "a clause or a list of clauses", fix="such as OBJ(f = the pallet)"
            )
        else:
            draft.words[field] = self._words("words" if field == "r" else "words or a clause")

    def _at_clause(self) -> bool:
        following = self._tokens[self._index + 1 : self._index + 2]
        return (
            self._next.kind == "bare"
            and _HEAD.fullmatch(self._next.text) is not None
            and any(token.kind == "mark" and token.text == "(" for token in following)
        )

    def _list(self, field: Field, depth: int) -> list[_Draft]:
        if self.skip("mark", "]"):
            return []
        if field == "r":
            raise self.unexpected("words in the relation field")
        drafts = [self.clause(depth + 1)]
        while self.skip("mark", ","):
            drafts.append(self.clause(depth + 1))
        if not self.skip("mark", "]"):
            raise self.unexpected("',' or ']'")
        return drafts

    def _words(self, expected: str) -> list[FieldWord]:
        words = []
        while self._next.kind in ("bare", "quoted"):
            words.append(self._word())
        if not words:
            raise self.unexpected(expected)
        return words

    def _word(self) -> FieldWord:
        token = self._take()
        where = self._where(token.offset)
        text = token.text
        if token.kind == "quoted":
            try:
                text = json.loads(text)
            except json.JSONDecodeError as error:
                raise SDCError(f"{text} is not a JSON string ({error.msg})", where=where) from None
            if not is_word(text):
                raise SDCError(
                    f"{token.text} is not one word", where=where, fix="quote each word by itself"
                )
        adjacent = self._next.offset == token.offset + len(token.text)
        if self._next.kind == "position" and adjacent:
            return FieldWord(text, int(self._take().text[1:]), where)
        return FieldWord(text, None, where)


FIELDS: tuple[Field, ...] = get_args(Field)

IMPLICIT_FIGURE = (SDC("OBJECT"),)
"""The figure of an imperative: the robot, which no word names."""

_PRINTED_TYPES: dict[SDCType, str] = {
    "EVENT": "EVENT",
    "OBJECT": "OBJ",
    "PLACE": "PLACE",
    "PATH": "PATH",
}


def has_implicit_figure(sdc: SDC) -> bool:
    """Check that a clause is an EVENT whose only figure is the unnamed robot."""
    return sdc.type == "EVENT" and sdc.figure == IMPLICIT_FIGURE


def field_words(sdc: SDC, field: Field) -> tuple[Span, ...]:
    """Return the words in one field of a clause."""
    return {"f": sdc.words, "r": sdc.relation}.get(field, ())


def check_sdc(sdc: SDC, *, where: str = "SDC") -> None:
    """Check that a tree is one the paper's definition allows (section 3.1).

    A leaf holds only words, in its figure field; in any other clause the figure and the
    landmarks are clauses and the relation holds words.

    Parameters
    ----------
    where
        Name of the source in an error.

    Raises
    ------
    SDCError
        If a clause has words in its figure and another field filled, if a word is empty,
        holds white space or stands before the command, if a type is unknown, or if
        clauses nest deeper than `MAX_DEPTH`.
    """
    pending = [(sdc, where, 1)]
    while pending:
        node, path, depth = pending.pop()
        if depth > MAX_DEPTH:
            raise SDCError(f"clauses nest deeper than {MAX_DEPTH} levels", where=where)
        if node.type not in SDC_TYPES:
            raise SDCError.unknown("type", node.type, SDC_TYPES, where=path)
        if node.words and not node.is_leaf:
            raise SDCError(
                "the figure holds words though other fields are filled",
                where=path,
                fix="put the words in an OBJECT in the figure field",
            )
        for field in FIELDS:
            for word in field_words(node, field):
                _check_word(word, f"{path}.{field}")
        pending += [
            (child, f"{path}.{field}[{i}]", depth + 1)
            for field in CHILD_FIELDS
            for i, child in enumerate(node.children(field))
        ]


def _check_word(word: Span, where: str) -> None:
    if not is_word(word.text):
        raise SDCError(f"{word.text!r} is not a word", where=where, fix="no white space, not empty")
    if word.start < 0:
        raise SDCError(f"the word {word.text!r} has the position {word.start}", where=where)


# Writing


def format_brackets(sdcs: Sequence[SDC], *, positions: bool = False) -> str:
    """Write clauses in the paper's notation (Figures 2a and 3a), one top-level clause a line.

    Parameters
    ----------
    positions
        Write each word's offset in the command after it, as in ``Put@0``. With them,
        :func:`parse_brackets` gives exactly the same clauses back.

    Raises
    ------
    SDCError
        If a clause isn't well formed.
    """
    for i, sdc in enumerate(sdcs):
        check_sdc(sdc, where=f"SDC {i + 1}")
    counter = iter(range(1, 10**9))
    return "\n".join(_format(sdc, counter, positions) for sdc in sdcs)


def _format(sdc: SDC, counter: Iterator[int], positions: bool) -> str:
    head = f"{_PRINTED_TYPES[sdc.type]}_{next(counter)}"
    fields = []
    for field in FIELDS:
        value = " ".join(format_word(word, positions=positions) for word in field_words(sdc, field))
        if field == "f" and sdc.type == "EVENT" and not (sdc.words or sdc.figure):
            value = "[]"
        elif not (field == "f" and has_implicit_figure(sdc)):
            value = value or _format_children(sdc.children(field), counter, positions)
        if value:
            fields.append(f"{field} = {value}")
    return f"{head}({', '.join(fields)})"


def _format_children(children: Sequence[SDC], counter: Iterator[int], positions: bool) -> str:
    texts = [_format(child, counter, positions) for child in children]
    return texts[0] if len(texts) == 1 else f"[{', '.join(texts)}]" if texts else ""


def format_word(word: Span, *, positions: bool = False) -> str:
    """Write a word, in quotes where it needs them.

    Parameters
    ----------
    word
        The word.
    positions
        True to write where it begins, too.
    """
    bare = word.text.isprintable() and BARE_WORD.fullmatch(word.text)
    text = word.text if bare else json.dumps(word.text, ensure_ascii=not word.text.isprintable())
    return f"{text}@{word.start}" if positions else text


# Reading


def parse_brackets(notation: str, *, command: str | None = None) -> tuple[SDC, ...]:
    """Read the top-level clauses that a text in the paper's notation holds.

    The numbers after the types may be missing and are not looked at. Words without a
    position are found in the command (:func:`g3.sdc.word_alignment.align_words`); where there
    is no command, they get the positions they have when all words are joined by spaces in
    the order of the notation.

    Parameters
    ----------
    notation
        The clauses, one a line or separated by semicolons; a line may be broken inside
        brackets.
    command
        The text that the words come from.

    Raises
    ------
    SDCError
        If the notation is malformed (with line and column), or if a word isn't in the
        command.
    """
    drafts = _read_clauses(notation)
    fields = [words for draft in drafts for words in _word_fields(draft)]
    spans = iter(align_words(fields, command) if command is not None else _invented(fields))
    return tuple(_build(draft, spans) for draft in drafts)


def _word_fields(draft: _Draft) -> Iterator[list[FieldWord]]:
    """Yield the word fields in the order in which :func:`_format` writes them."""
    for field in FIELDS:
        if field in draft.words:
            yield draft.words[field]
        for child in draft.children.get(field, ()):
            yield from _word_fields(child)


def _invented(fields: Sequence[Sequence[FieldWord]]) -> list[tuple[Span, ...]]:
    words = [word for field in fields for word in field]
    bare = [word for word in words if word.start is None]
    if bare and len(bare) < len(words):
        raise SDCError(
            f"the word {bare[0].text!r} has no position though others have one",
            where=bare[0].where,
            fix="give all words a position, or none, or give the command",
        )
    start = 0
    placed = []
    for field in fields:
        spans = []
        for word in field:
            spans.append(Span(start if word.start is None else word.start, word.text))
            start += len(word.text) + 1
        placed.append(tuple(spans))
    return placed


def _build(draft: _Draft, spans: Iterator[tuple[Span, ...]]) -> SDC:
    words: dict[Field, tuple[Span, ...]] = {}
    children: dict[Field, tuple[SDC, ...]] = {}
    for field in FIELDS:
        if field in draft.words:
            words[field] = next(spans)
        children[field] = tuple(_build(child, spans) for child in draft.children.get(field, ()))
    figure_given = "f" in draft.words or "f" in draft.children
    if draft.type == "EVENT" and not figure_given:
        children["f"] = IMPLICIT_FIGURE
    return SDC(
        draft.type,
        words=words.get("f", ()),
        relation=words.get("r", ()),
        figure=children["f"],
        landmark1=children["l"],
        landmark2=children["l2"],
    )


# JSON


def to_json(sdcs: Sequence[SDC]) -> list[dict[str, Any]]:
    """Clauses as plain JSON values.

    A clause is an object with a ``type`` and the fields that are filled: ``f``, ``r``,
    ``l``, ``l2``. A word is ``[text, start]``; a field is a list of words or of clauses.
    Nothing is left out, so that the implicit figure of an imperative is
    ``{"type": "OBJECT"}``.

    Raises
    ------
    SDCError
        If a clause isn't well formed.
    """
    for i, sdc in enumerate(sdcs):
        check_sdc(sdc, where=f"SDC {i + 1}")
    return [_clause_to_json(sdc) for sdc in sdcs]


def _clause_to_json(sdc: SDC) -> dict[str, Any]:
    fields: dict[str, Any] = {"type": sdc.type}
    for field in FIELDS:
        words: list[Any] = [[word.text, word.start] for word in field_words(sdc, field)]
        value = words or [_clause_to_json(child) for child in sdc.children(field)]
        if value:
            fields[field] = value
    return fields


def from_json(value: object) -> tuple[SDC, ...]:
    """Read the clauses that :func:`to_json` wrote.

    Raises
    ------
    SDCError
        If the value has another form, with the place where it does.
    """
    if not isinstance(value, list):
        raise SDCError("expected a list of clauses", where="SDCs")
    sdcs = tuple(_clause_from_json(item, f"SDC {i + 1}") for i, item in enumerate(value))
    for i, sdc in enumerate(sdcs):
        check_sdc(sdc, where=f"SDC {i + 1}")
    return sdcs


def _clause_from_json(value: object, where: str, depth: int = 1) -> SDC:
    if depth > MAX_DEPTH:
        raise SDCError(f"clauses nest deeper than {MAX_DEPTH} levels")
    if not isinstance(value, dict):
        raise SDCError("expected a clause, an object with a type", where=where)
    unknown = sorted(str(key) for key in value if key not in ("type", *FIELDS))
    if unknown:
        raise SDCError.unknown("field", unknown[0], ("type", *FIELDS), where=where)
    if value.get("type") not in SDC_TYPES:
        raise SDCError.unknown("type", value.get("type"), SDC_TYPES, where=where)
    lists = {field: _json_list(value, field, where) for field in FIELDS}
    figure_words = bool(lists["f"]) and isinstance(lists["f"][0], list)

    def children(field: Field) -> tuple[SDC, ...]:
        return tuple(
            _clause_from_json(item, f"{where}.{field}[{i}]", depth + 1)
            for i, item in enumerate(lists[field])
        )

    return SDC(
        value["type"],
        words=_words_from_json(lists["f"], f"{where}.f") if figure_words else (),
        relation=_words_from_json(lists["r"], f"{where}.r"),
        figure=() if figure_words else children("f"),
        landmark1=children("l"),
        landmark2=children("l2"),
    )


def _json_list(clause: dict[Any, Any], field: str, where: str) -> list[Any]:
    value = clause.get(field, [])
    if not isinstance(value, list):
        raise SDCError("expected a list of words or clauses", where=f"{where}.{field}")
    return value


def _words_from_json(values: list[Any], where: str) -> tuple[Span, ...]:
    spans = []
    for i, value in enumerate(values):
        match value:
            case [str(text), int(start)] if not isinstance(start, bool):
                spans.append(Span(start, text))
            case _:
                raise SDCError("expected a word, [text, start]", where=f"{where}[{i}]")
    return tuple(spans)
