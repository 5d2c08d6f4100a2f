"""Negated clauses: what the robot must not do ("Don't pick up the crate")."""

from __future__ import annotations

import re

from g3.language.discourse.groups import noun_words
from g3.language.lexicon.tables import WORDS, rows
from g3.sdc.clauses import SDC

_PATTERN = rows()["negation"].pattern
_NEGATION = re.compile(_PATTERN, re.IGNORECASE)
_BEFORE = re.compile(rf"(?<![^\W_])(?:{_PATTERN})(?:\s+(?:ever|please))?\s*$", re.IGNORECASE)


def is_negation(word: str) -> bool:
    """Check that a word negates what follows: "not", "don't"."""
    return bool(_NEGATION.fullmatch(word))


def negated(sdc: SDC, text: str = "") -> bool:
    """Check that a clause says what must not be, so that its φ is False.

    A clause is negated by a word of its own relation, or if it is about nothing. The clauses
    inside are not: of "don't touch the crate on the truck" only the EVENT is, not that the crate
    is on the truck.

    Parameters
    ----------
    sdc
        A clause.
    text
        Its command. If given, a negation that stands right before the relation and was left
        out of the tree counts as well.

    Examples
    --------
    >>> from g3.sdc.sdc_notation import parse_brackets
    >>> text = "Don't touch the crate"
    >>> (sdc,) = parse_brackets("EVENT(r = Don't touch, l = OBJ(f = the crate))", command=text)
    >>> negated(sdc)
    True
    """
    words = sdc.relation
    if sdc.type == "EVENT" and WORDS["nothing"].intersection(
        word.text.lower() for word in words[:1]
    ):
        return True  # "nothing to lift"
    if sdc.type == "EVENT" and any(map(_is_none, sdc.children())):
        return True
    for place, word in enumerate(words):
        if is_negation(word.text):
            following = "".join(w.text.lower() for w in words[place + 1 : place + 2])
            return following not in WORDS["doubled"]
    return bool(words and _BEFORE.search(text[: words[0].start]))


def _is_none(sdc: SDC) -> bool:
    """Check that an argument says that there is none: "nothing", "no crate", "nowhere"."""
    if sdc.type == "PLACE":
        return any(word.text.lower() == "nowhere" for word in sdc.relation)
    none = WORDS["nothing"] | WORDS["negating_nouns"]
    return sdc.type == "OBJECT" and not none.isdisjoint(noun_words(sdc)[:1])
