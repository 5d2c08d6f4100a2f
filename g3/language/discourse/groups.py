"""Numbers of things that OBJECTs speak of: "both tires", "the row of pallets"."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from g3.language.lexicon.field_words import bare, bare_words
from g3.language.lexicon.tables import COUNTS, WORDS
from g3.sdc.clauses import SDC
from g3.short_repr import short_repr

Number = Literal["singular", "plural"]


_ORDINALS = {**COUNTS["ordinals"], "last": -1, "final": -1}
_QUANTITIES = {
    *WORDS["quantifiers"],
    *COUNTS["counts"],
    *WORDS["rest"],
    *WORDS["ones"],
    *WORDS["articles"],
}
_TIMES = re.compile(r"[x×]?(\d{1,3})[x×]?")
_NOT_PLURAL = ("ss", "us", "is", "'s", "’s")


@short_repr
@dataclass(frozen=True, slots=True)
class Group:
    """Number of things that the words of an OBJECT speak of.

    Parameters
    ----------
    number
        Whether it speaks of one thing or several.
    count
        How many, where the words say it.
    quantifier
        "all", "both", "each", "any" and so on; empty where there is none.
    ordinals
        Places in an order, from 1; -1 is the last: (1, 2) of "the first and second pallet".
    collective
        The noun that stands for several things, "row" of "the row of pallets"; else empty.
    """

    number: Number
    count: int | None = None
    quantifier: str = ""
    ordinals: tuple[int, ...] = ()
    collective: str = ""


def group(sdc: SDC) -> Group:
    """Return the number of things that an OBJECT speaks of.

    The grammar of the words is looked at, no more: "tires" is plural also where a map has all
    tires of a pallet as one object.

    Parameters
    ----------
    sdc
        An OBJECT, a leaf or one with modifiers.

    Examples
    --------
    >>> from g3.sdc.sdc_notation import parse_brackets
    >>> text = "the first and second pallets"
    >>> (sdc,) = parse_brackets(f"OBJ(f = {text})", command=text)
    >>> group(sdc)
    Group(number='plural', count=2, quantifier='', ordinals=(1, 2), collective='')
    """
    words = quantity_words(sdc)
    counting = words or noun_words(sdc)[:-1]
    words = words or noun_words(sdc)
    if not words:
        return Group("singular")
    head = words[-1]
    several = any((_number(word) or 0) > 1 for word in counting)
    number: Number = "plural" if several or _is_plural(words) else "singular"
    ordinals = tuple(_ORDINALS[word] for word in words if word in _ORDINALS)
    quantifier = next((word for word in words if word in WORDS["quantifiers"]), "")
    count = _count(words, number, ordinals)
    if head not in WORDS["collectives"]:
        return Group(number, count, quantifier, ordinals)
    inside = _members(sdc)
    count = COUNTS["counts"].get(
        head, inside.count if inside and inside.number == "plural" else None
    )
    return Group(
        "plural", count, quantifier or (inside.quantifier if inside else ""), ordinals, head
    )


def noun_words(sdc: SDC) -> list[str]:
    """Return the words of the noun itself, in lower case, without what modifies it.

    Those of "one of the three crates" begin with "one".
    """
    return [*quantity_words(sdc), *(bare(word.text) for word in noun_leaf(sdc).words)]


def noun_leaf(sdc: SDC) -> SDC:
    """Return the leaf that has the noun of an OBJECT: "the crates" of "one of the crates"."""
    while sdc.figure:
        sdc = sdc.landmark1[0] if is_partitive(sdc) else sdc.figure[0]
    return sdc


def quantity_words(sdc: SDC) -> list[str]:
    """Return "one" of "one of the crates"; no words where an OBJECT has no such part."""
    while sdc.figure:
        if is_partitive(sdc):
            return bare_words(sdc.figure[0].words)
        sdc = sdc.figure[0]
    return []


def is_partitive(sdc: SDC) -> bool:
    """Check that an OBJECT says how many of some things it means: "three of the four crates"."""
    of = [word.text.lower() for word in sdc.relation] == ["of"]
    if not (of and sdc.figure and sdc.landmark1 and sdc.figure[0].is_leaf):
        return False
    said = bare_words(sdc.figure[0].words)
    return bool(said) and all(word in _QUANTITIES or word.isdecimal() for word in said)


def _members(sdc: SDC) -> Group | None:
    """Return the members of a group, if they are named: "the row *of pallets*"."""
    while sdc.figure:
        if [word.text.lower() for word in sdc.relation] == ["of"] and sdc.landmark1:
            return group(sdc.landmark1[0])
        sdc = sdc.figure[0]
    return None


def _is_plural(words: Sequence[str]) -> bool:
    head = words[-1]
    if "and" in words or "both" in words or "all" in words:
        return True
    if head in WORDS["singular"] or words[0] in WORDS["single"]:
        return False
    alone = len(words) == 1 or words[-2] in WORDS["rest"]
    if head in WORDS["plural"] or (alone and (_number(head) or 0) > 1):
        return True
    return len(head) > 2 and head.endswith("s") and not head.endswith(_NOT_PLURAL)


def _number(word: str) -> int | None:
    """Return the number that a word counts, if any: "three", "3", "x3"."""
    if word in COUNTS["counts"]:
        return COUNTS["counts"][word]
    times = _TIMES.fullmatch(word)
    return int(times[1]) if times else None


def _count(words: Sequence[str], number: Number, ordinals: Sequence[int]) -> int | None:
    for place, word in enumerate(words, start=1):
        counted = _number(word)
        rest = place > 1 and words[place - 2] in WORDS["rest"]
        if counted is not None and (
            not word.isdecimal() or place < len(words) or place == 1 or rest
        ):
            return counted  # not of "truck 3"
    if number == "singular":
        return 1
    return len(ordinals) if len(ordinals) > 1 else None
