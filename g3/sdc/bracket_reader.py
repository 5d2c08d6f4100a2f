"""Reads the bracket notation into clauses whose words are not placed in a command yet.

:func:`g3.sdc.sdc_notation.parse_brackets` is the way in; this is its grammar::

    clauses = [clause] { separator [clause] }        separator = newline | ";"
    clause  = type [["_"] number] "(" [field {"," field}] ")"
    field   = name "=" (clause | "[" [clause {"," clause}] "]" | word {word})
    word    = (bare | JSON string) ["@" position]
"""

from __future__ import annotations

import json
import re
from bisect import bisect_right
from collections.abc import Iterator
from typing import NamedTuple

from g3.errors import SDCError
from g3.lengths import MAX_NOTATION, check_length
from g3.sdc.clauses import Field, SDCType
from g3.sdc.word_alignment import FieldWord

MAX_DEPTH = 64
"""How deep clauses may nest; the deepest of the paper's corpus has five levels."""

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


class Draft(NamedTuple):
    """A clause as it was written.

    Parameters
    ----------
    children
        The clauses of the fields that hold clauses, or nothing (``f = []``).
    """

    type: SDCType
    words: dict[Field, list[FieldWord]]
    children: dict[Field, list[Draft]]


class _Token(NamedTuple):
    kind: str
    text: str
    offset: int


def is_word(text: str) -> bool:
    """Whether a text is one word: not empty and without white space."""
    return bool(text) and not any(character.isspace() for character in text)


def read_clauses(notation: str) -> list[Draft]:
    """Read the top-level clauses of a notation.

    Raises
    ------
    SDCError
        If it is longer than :data:`g3.lengths.MAX_NOTATION`; where it leaves the grammar, with
        line, column and what was expected.
    """
    check_length(notation, MAX_NOTATION, error=SDCError)
    reader = _Reader(notation)
    drafts: list[Draft] = []
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
        found = self._next.kind == kind and text in ("", self._next.text)
        if found:
            self._take()
        return found

    def _where(self, offset: int) -> str:
        line = bisect_right(self._line_starts, offset)
        column = offset - self._line_starts[line - 1] + 1
        return f"line {line}, column {column}" if line > 1 else f"column {column}"

    def unexpected(self, expected: str, fix: str = "") -> SDCError:
        """The error that something else stands where ``expected`` should."""
        token = self._next
        found = "the notation ends" if token.kind == "end" else f"found {token.text!r}"
        if token.text == '"':
            fix = "the quoted word has no end"
        elif token.text == "@":
            fix = "a position is '@' and at most 18 digits, right after its word"
        elif token.text in ("(", "["):
            fix = "quote a word that holds a bracket"
        return SDCError(
            f"expected {expected}, but {found}", where=self._where(token.offset), fix=fix
        )

    def clause(self, depth: int = 1) -> Draft:
        """Read one clause, from its type to its closing bracket."""
        start = self._next.offset
        head = _HEAD.fullmatch(self._next.text) if self._next.kind == "bare" else None
        if head is None:
            raise self.unexpected("a clause", fix="such as OBJ(f = the pallet)")
        if depth > MAX_DEPTH:
            raise SDCError(f"clauses nest deeper than {MAX_DEPTH} levels", where=self._where(start))
        self._take()
        if not self.skip("mark", "("):
            raise self.unexpected(f"'(' after {head.group()}")
        draft = Draft(_TYPES[head.group(1)], {}, {})
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

    def _field(self, draft: Draft, depth: int) -> None:
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

    def _list(self, field: Field, depth: int) -> list[Draft]:
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
