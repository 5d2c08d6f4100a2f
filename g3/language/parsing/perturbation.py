"""The same command as other people type it: without articles, misspelt, in capitals, run on.

A perturbed command says the same, so that its trees and groundings are those of the command: words
that stay keep their clauses.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from g3.errors import FormatError
from g3.language.lexicon.tables import WORDS
from g3.sdc.clauses import SDC, Span, breadth_first
from g3.short_repr import short_repr

SHORTEST_MISSPELT = 4
"""Shorter words aren't misspelt."""
_ARTICLES = "|".join(sorted(WORDS["articles"]))
_ARTICLE = re.compile(rf"\b(?:{_ARTICLES})\s+(?=[^\W\d_]{{2}})", re.IGNORECASE)
_MARK = re.compile(r"[.,;:!?]+(?=\s|$)")
_WORD = re.compile(rf"[a-z]{{{SHORTEST_MISSPELT},}}", re.IGNORECASE)
_KEYS = ("qwertyuiop", "asdfghjkl", "zxcvbnm")


class Edit(NamedTuple):
    """The characters from `start` to `end`, and what is typed instead."""

    start: int
    end: int
    text: str = ""


@short_repr
@dataclass(frozen=True, slots=True)
class Perturbed:
    """A command as somebody else might type it.

    Parameters
    ----------
    text
        What is typed.
    origin
        Where each of its characters comes from: an offset in the command, never decreasing.
    """

    text: str
    origin: tuple[int, ...]

    def carry(self, sdcs: Sequence[SDC]) -> tuple[SDC, ...]:
        """The command's clauses in the words that are typed; what isn't typed is left out."""
        return tuple([self._clause(sdc) for sdc in sdcs])

    def _clause(self, sdc: SDC) -> SDC:
        return SDC(
            sdc.type,
            self._spans(sdc.words),
            self._spans(sdc.relation),
            *(self.carry(sdc.children(field)) for field in ("f", "l", "l2")),
        )

    def _spans(self, spans: Sequence[Span]) -> tuple[Span, ...]:
        found = [self._span(span) for span in spans]
        return tuple([span for span in found if span.text])

    def _span(self, span: Span) -> Span:
        start, end = np.searchsorted(self.origin, [span.start, span.end]).tolist()
        typed = self.text[start:end]
        return Span(start + len(typed) - len(typed.lstrip()), typed.strip())


def perturb(text: str, kind: str, *, seed: int = 0, sdcs: Sequence[SDC] = ()) -> Perturbed:
    """Type a command in another way; the same arguments give the same text.

    Parameters
    ----------
    text
        The command.
    kind
        A name of `PERTURBATIONS`.
    seed
        What is drawn with, and the text.
    sdcs
        Its clauses, if known; none of their fields loses all of its words.

    Raises
    ------
    FormatError
        If there is no such kind.
    """
    if kind not in PERTURBATIONS:
        raise FormatError.unknown("perturbation", kind, PERTURBATIONS)
    lone = {
        fields[0]
        for sdc in breadth_first(sdcs)
        for fields in (sdc.words, sdc.relation)
        if len(fields) == 1
    }
    digest = hashlib.sha256(f"{seed} {kind} {text}".encode(errors="surrogatepass")).digest()
    rng = np.random.default_rng(int.from_bytes(digest[:8], "big"))
    return _applied(text, [e for e in PERTURBATIONS[kind](text, rng) if not _removes(e, lone)])


def _removes(edit: Edit, spans: Collection[Span]) -> bool:
    return not edit.text and any(edit.start <= s.start and s.end <= edit.end for s in spans)


def _applied(text: str, edits: Sequence[Edit]) -> Perturbed:
    typed: list[str] = []
    origin: list[int] = []
    at = 0
    for edit in (*edits, Edit(len(text), len(text))):
        typed += [text[at : edit.start], edit.text]
        origin += range(at, edit.start)
        last = edit.end - 1
        origin += [min(edit.start + i, last) for i in range(len(edit.text))]
        at = edit.end
    return Perturbed("".join(typed), tuple(origin))


def without_articles(text: str, _: np.random.Generator) -> Iterator[Edit]:
    """Leave out "the", "a" and "an" before a word."""
    return (Edit(*found.span()) for found in _ARTICLE.finditer(text))


def with_a_typo(text: str, rng: np.random.Generator) -> Iterator[Edit]:
    """Misspell one word after its first letter: one left out, doubled, swapped, or a key aside."""
    words = list(_WORD.finditer(text))
    if words:
        word = words[rng.integers(len(words))]
        slips = [slip for slip in _slips(word.group(), rng) if slip != word.group()]
        yield Edit(*word.span(), slips[rng.integers(len(slips))])


def _slips(word: str, rng: np.random.Generator) -> Iterator[str]:
    at = int(rng.integers(1, len(word)))
    yield word[:at] + word[at + 1 :]
    yield word[:at] + word[at] + word[at:]
    if at + 1 < len(word):
        yield word[:at] + word[at + 1] + word[at] + word[at + 2 :]
    row = next(keys for keys in _KEYS if word[at].lower() in keys)
    key = row.index(word[at].lower())
    beside = [row[i] for i in (key - 1, key + 1) if 0 <= i < len(row)]
    yield word[:at] + beside[rng.integers(len(beside))] + word[at + 1 :]


def in_capitals(text: str, _: np.random.Generator) -> Iterator[Edit]:
    """Type all in capitals."""
    return (Edit(i, i + 1, c.upper()) for i, c in enumerate(text) if c.upper() != c)


def run_on(text: str, _: np.random.Generator) -> Iterator[Edit]:
    """Leave out punctuation after words."""
    return (Edit(*found.span()) for found in _MARK.finditer(text))


PERTURBATIONS: Mapping[str, Callable[[str, np.random.Generator], Iterator[Edit]]] = {
    "articles": without_articles,
    "typos": with_a_typo,
    "capitals": in_capitals,
    "run-on": run_on,
}
"""Ways to type a command, by name. Edits are in order and don't overlap."""
