"""How far and how much, apart from which way: "10 feet forward", "90 degrees clockwise".

Trees have the words of a measure in a PLACE, in a PATH or in an OBJECT, with or without a side.
Here it is an OBJECT of its own, and the side is the clause's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from g3.inference.problem.joined_clauses import arguments_of, verb_words, whole_words
from g3.inference.problem.phrases import names_forks
from g3.language.lexicon.concepts import concepts
from g3.language.lexicon.field_words import bare, field_words, normalise
from g3.language.lexicon.measures import is_amount, metres_said, seconds_said
from g3.language.lexicon.verb_chains import verb_of
from g3.language.lexicon.word_sets import ABOUT, AROUND, SIDES, STRAIGHT
from g3.sdc.clauses import SDC, Span, all_words


def measures_apart(sdc: SDC) -> SDC:
    """A clause with its measures as OBJECTs of their own; the same one if it has none.

    What is put down "two metres ahead", or goes "two metres to the left", is measured by its place.
    """
    named = [p for p in arguments_of(sdc) if p.type == "OBJECT"]
    classes = verb_of(tuple(verb_words(sdc))).classes
    if classes & {"placing", "taking"} and not any(map(names_forks, named)):
        return sdc
    waits = classes == {"staying"}
    first, second = (_parts(own, waits=waits) for own in (sdc.landmark1, sdc.landmark2))
    sides = tuple(word for _, ways in (*first, *second) for word in ways)
    if not sides and [p for p, _ in (*first, *second)] == [*sdc.landmark1, *sdc.landmark2]:
        return sdc
    return replace(
        sdc,
        relation=tuple(sorted((*sdc.relation, *sides), key=lambda word: word.start)),
        landmark1=tuple(part for part, _ in first),
        landmark2=tuple(part for part, _ in second),
    )


def _parts(arguments: Sequence[SDC], *, waits: bool) -> list[tuple[SDC, tuple[Span, ...]]]:
    """Arguments, each with the words in it that name a side; those of things stay in them."""
    return [_measure(part, waits=waits) or (part, ()) for part in arguments]


def _measure(part: SDC, *, waits: bool) -> tuple[SDC, tuple[Span, ...]] | None:
    said = whole_words(sorted(all_words(part), key=lambda word: word.start))
    ways = tuple(word for word in said if _is_way(bare(word.text)))
    rest = [word for word in said if word not in ways]
    while rest and bare(rest[0].text) in ABOUT:
        rest.pop(0)
    while rest and bare(rest[-1].text) in ABOUT:
        rest.pop()
    words = [own for word in rest if (own := bare(word.text))]
    if not (is_amount(words) or (waits and seconds_said(words))):
        return None
    aside = {"left", "right"} & concepts(field_words(ways))
    if aside and metres_said(words) is not None:
        return None
    return SDC("OBJECT", words=tuple(rest)), ways


def _is_way(word: str) -> bool:
    stem = normalise(word)
    return bool(SIDES & concepts([stem])) or stem in AROUND or word in STRAIGHT
