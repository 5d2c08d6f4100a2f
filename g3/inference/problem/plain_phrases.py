"""Phrases inside clauses, as phrases that say the same plainly.

"The crate that is by the gate" is the crate by the gate. "On the ground by the gate" is by the
gate, and not on top of it. What is picked up "on the truck" stands there already. Words are left
out or moved, never made up.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

from g3.language.discourse.groups import noun_leaf
from g3.language.lexicon.concepts import concepts
from g3.language.lexicon.field_words import bare, field_words
from g3.language.lexicon.verb_chains import verb_of
from g3.language.lexicon.word_sets import BESIDE, FLOOR, HAVING, IT, WORD_CLASSES, words
from g3.sdc.clauses import SDC, Span, all_words

_WHICH = words(WORD_CLASSES["relative"])
_BEING = words(WORD_CLASSES["being"]) | {"s", "'s"}


def plain_phrases(sdc: SDC) -> SDC:
    """A clause whose phrases are plain ones, and those of the clauses inside."""
    sdc = replace(
        sdc,
        figure=tuple(map(plain_phrases, sdc.figure)),
        landmark1=tuple(map(plain_phrases, sdc.landmark1)),
        landmark2=tuple(map(plain_phrases, sdc.landmark2)),
    )
    if sdc.type == "OBJECT":
        return _without_copula(sdc)
    if sdc.type == "PLACE":
        return _beside(sdc)
    if sdc.type == "EVENT":
        return _picked_up_there(_one_place(sdc))
    return sdc


def _without_copula(sdc: SDC) -> SDC:
    """The crate by the gate, where words say "the crate that is standing by the gate"."""
    said = list(map(_bare, sdc.relation))
    if not (sdc.figure and sdc.landmark1 and said) or said[0] not in _WHICH:
        return sdc
    copula = next((i for i, word in enumerate(said[1:], 1) if word not in _BEING), len(said))
    if copula in (1, len(said)):
        return sdc
    return replace(sdc, relation=sdc.relation[copula:])


def _is_floor(sdc: SDC) -> bool:
    """Whether a clause means the ground alone."""
    return sdc.type == "OBJECT" and bool(FLOOR.intersection(field_words(noun_leaf(sdc).words)))


def _says_beside(sdc: SDC) -> bool:
    """Whether a relation leads beside something, so that nothing is on top of it."""
    said = concepts(field_words(sdc.relation))
    return bool(sdc.landmark1) and bool(said & BESIDE) and "on" not in said


def _beside(place: SDC) -> SDC:
    """A place beside something, where words say "on the ground beside it"."""
    if len(place.landmark1) != 1 or place.landmark2:
        return place
    (mark,) = place.landmark1
    if not (mark.figure and _is_floor(mark) and _says_beside(mark)):
        return place
    return replace(
        place, relation=mark.relation, landmark1=mark.landmark1, landmark2=mark.landmark2
    )


def _one_place(event: SDC) -> SDC:
    """A clause without "on the ground", where another place is beside something."""
    arguments = (*event.landmark1, *event.landmark2)
    places = [part for part in arguments if part.type == "PLACE"]
    floors = [p for p in places if len(p.landmark1) == 1 and _is_floor(p.landmark1[0])]
    if not any(_says_beside(p) for p in places if p not in floors):
        floors = []
    said = [*floors, *(b for a, b in pairwise(places) if _has(a) and _is_on_it(b))]
    first, second = (
        tuple(part for part in own if part not in said)
        for own in (event.landmark1, event.landmark2)
    )
    return replace(event, landmark1=first, landmark2=second)


def _has(place: SDC) -> bool:
    """Whether a place is at a thing that has something: "on the truck that has a crate"."""
    return any(not HAVING.isdisjoint(map(_bare, m.relation)) for m in place.landmark1)


def _is_on_it(place: SDC) -> bool:
    """Whether a place is on what was just named: "on it"."""
    marks = [word for mark in place.landmark1 for word in all_words(mark)]
    return bool(marks) and IT.issuperset(map(_bare, marks)) and "on" in map(_bare, place.relation)


def _bare(word: Span) -> str:
    return bare(word.text)


def _picked_up_there(event: SDC) -> SDC:
    """A clause about a thing that stands somewhere, where what is picked up is said to be there."""
    verb = verb_of(tuple(map(_bare, event.relation)))
    arguments = (*event.landmark1, *event.landmark2)
    if verb.classes != {"taking"} or [part.type for part in arguments] != ["OBJECT", "PLACE"]:
        return event
    theme, place = arguments
    leads = "to" in concepts(field_words(place.relation))
    if theme.is_implicit or leads or not place.landmark1:
        return event
    return replace(event, landmark1=(replace(place, type="OBJECT", figure=(theme,)),), landmark2=())
