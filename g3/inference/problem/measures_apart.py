"""Measures apart from directions: "10 feet forward", "90 degrees clockwise".

Trees have the words of a measure in a PLACE, in a PATH or in an OBJECT, with or without a side.
Here it is an OBJECT of its own, and the side is the clause's.
"""

from __future__ import annotations

from dataclasses import replace

from g3.inference.problem.phrases import (
    arguments_of,
    is_measure,
    names_forks,
    side_by_side,
    verb_words,
    whole_words,
)
from g3.language.lexicon.concepts import SIDES, concepts
from g3.language.lexicon.field_words import bare, bare_words, field_words, normalise
from g3.language.lexicon.measures import is_amount, metres_said, seconds_said
from g3.language.lexicon.tables import WORDS
from g3.language.lexicon.verb_chains import verb_of
from g3.sdc.clauses import SDC, Span, all_words

_SPACE = len(" ")
_Apart = tuple[SDC | None, tuple[Span, ...]]
"""What stays an argument of a clause, and the words that become the clause's own."""


def measures_apart(sdc: SDC) -> SDC:
    """A clause with its measures as OBJECTs of their own; the same one if it has none.

    What is put down "two metres ahead", or goes "two metres to the left", is measured by its place.
    """
    named = [p for p in arguments_of(sdc) if p.type == "OBJECT"]
    classes = verb_of(tuple(verb_words(sdc))).classes
    stays = "staying" in classes
    if not stays and classes & {"placing", "taking"} and not any(map(names_forks, named)):
        return _with_distance(sdc)
    first, second = (
        [_time(part) if stays else _measure(part) for part in own]
        for own in (sdc.landmark1, sdc.landmark2)
    )
    moved = [word for _, words in (*first, *second) for word in words]
    own = sorted((*sdc.relation, *moved), key=lambda word: word.start) if moved else sdc.relation
    return replace(
        sdc,
        relation=tuple(own),
        landmark1=tuple(part for part, _ in first if part),
        landmark2=tuple(part for part, _ in second if part),
    )


def _with_distance(sdc: SDC) -> SDC:
    """A clause whose place has the measure before it: "five metres", "to the left of the truck"."""
    found: list[SDC] = []
    for part in sdc.landmark2:
        before = found[-1] if found else None
        leads = part.type in ("PLACE", "PATH") and before is not None and is_measure(before)
        if before is not None and leads and side_by_side(before, part, _SPACE):
            found[-1] = replace(part, relation=(*before.words, *part.relation))
        else:
            found.append(part)
    return replace(sdc, landmark2=tuple(found))


def _time(part: SDC) -> _Apart:
    """Make a time of waiting the clause's own words: nothing is meant by it."""
    words = tuple(sorted(all_words(part), key=lambda word: word.start))
    is_time = seconds_said(bare_words(words)) is not None
    return (None, words) if is_time else (part, ())


def _measure(part: SDC) -> _Apart:
    """A measure, and the words in it that name a side; those of things stay in them."""
    said = whole_words(sorted(all_words(part), key=lambda word: word.start))
    ways = tuple(word for word in said if _is_way(bare(word.text)))
    rest = [word for word in said if word not in ways]
    while rest and bare(rest[0].text) in WORDS["about"]:
        rest.pop(0)
    while rest and bare(rest[-1].text) in WORDS["about"]:
        rest.pop()
    words = [own for word in rest if (own := bare(word.text))]
    aside = {"left", "right"} & concepts(field_words(ways))
    is_aside = bool(aside) and metres_said(words) is not None
    if part.type == "EVENT" or is_aside or not is_amount(words):
        return part, ()
    return SDC("OBJECT", words=tuple(rest)), ways


def _is_way(word: str) -> bool:
    stem = normalise(word)
    return bool(SIDES & concepts([stem])) or stem in WORDS["around"] or word in WORDS["straight"]
