"""Clauses without a verb: "tires to the truck, boxes to the trailer"."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from g3.language.lexicon.verb_chains import is_verb
from g3.language.lexicon.word_sets import (
    ARTICLES,
    NOT_IMPERATIVE,
    PLACE_PREPOSITIONS,
    SENTENCE_ENDS,
    words,
)
from g3.language.parsing.numbered_steps import Token

IMPLIED = "put"
"""What such a clause is read with."""
_TO = words("to onto into on")
_NO_GOAL = words("next close closer closest near nearer nearest adjacent according opposite due")
"""Words before "to" that don't say where something goes."""
_SIDES = words("left right front back rear side")
_NO_NAME = (NOT_IMPERATIVE | PLACE_PREPOSITIONS | words("up down over out back")) - (
    ARTICLES | words("your this that these those one two three")
)
_TOO = words("too also")
_JOINS = words(", . and & then also -")
_BREAKS = _JOINS | SENTENCE_ENDS
_UNITS = words("then") | SENTENCE_ENDS


def apart(tokens: Sequence[Token]) -> tuple[list[Token], frozenset[int]]:
    """Words of a text, with each clause that has no verb as a sentence; and where such begin.

    Such a clause names a thing and where it goes. No verb is left out where the text has one, up
    to the next "then".

    >>> words = "tires to the truck and boxes onto it , then lift the crate".split()
    >>> told, begins = apart([(0, 0, word) for word in words])
    >>> " ".join(word for _, _, word in told), sorted(begins)
    ('tires to the truck . boxes onto it . then lift the crate', [0, 5])
    >>> apart([(0, 0, word) for word in "lift it , the one next to the crate".split()])[1]
    frozenset()
    """
    said = [word for _, _, word in tokens]
    clauses = [
        part
        for unit in _split(range(len(said)), said, _UNITS)
        if not any(is_verb(said[i]) for i in unit)
        for part in _split(unit, said, _BREAKS)
        if _leads(said[part[0] : part[-1] + 1])
    ]
    told: list[Token] = []
    begins: set[int] = set()
    after = 0
    for part in clauses:
        told = _ended([*told, *tokens[after : part[0]]])
        begins.add(len(told))
        told += [tokens[i] for i in part if said[i] not in _TOO]
        after = part[-1] + 1
        if after < len(tokens):
            told.append((*tokens[after][:2], "."))
            after += 1
    return [*told, *tokens[after:]], frozenset(begins)


def _ended(told: list[Token]) -> list[Token]:
    """Words before a clause, with the end of a sentence for what joins it to them."""
    kept = len(told)
    while kept and told[kept - 1][2] in _JOINS:
        kept -= 1
    joins = told[kept:]
    return [*told[:kept], *((*join[:2], ".") for join in joins[:1] if kept)]


def _split(places: Sequence[int], said: Sequence[str], at: frozenset[str]) -> Iterator[list[int]]:
    """Places of words, divided where some words stand; those are left out."""
    part: list[int] = []
    for i in places:
        if said[i] not in at:
            part.append(i)
        elif part:
            yield part
            part = []
    if part:
        yield part


def _leads(said: Sequence[str]) -> bool:
    """Whether words name a thing and then where it goes."""
    if said[0] in _NO_NAME:
        return False
    for at, word in enumerate(said[1:-1], start=1):
        if word in _TO and said[at - 1] not in _NO_GOAL:
            goal = [w for w in said[at + 1 :] if w not in ARTICLES]
            if goal and not (goal[0] in _SIDES and goal[1:2] in ([], ["of"], ["side"])):
                return True
    return False
