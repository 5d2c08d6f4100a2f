"""Phrases inside clauses, as phrases that say the same plainly.

"The crate that is by the gate" is the crate by the gate. "On the ground by the gate" is by the
gate, and not on top of it. What is picked up "on the truck" stands there already. Words are left
out or moved, never made up.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

from g3.features.sets.order import is_ordinal
from g3.inference.problem.phrases import is_floor, is_pronoun, side_by_side
from g3.language.discourse.groups import noun_leaf
from g3.language.lexicon.concepts import concepts
from g3.language.lexicon.field_words import bare, field_words
from g3.language.lexicon.verb_chains import verb_of
from g3.language.lexicon.word_sets import (
    ARTICLES,
    ASIDE,
    BESIDE,
    BRINGING,
    HANDS,
    HAVING,
    IT,
    ONES,
    PARTS,
    PRONOUNS,
    RELATIVE,
    SIDES,
    STRESSING,
    WORD_CLASSES,
    YOU,
    words,
)
from g3.sdc.clauses import SDC, Span, all_words

COMMA = len(" - ")
"""Two phrases so far apart have nothing between them but a comma or a dash."""
_CLOSED = ARTICLES | PRONOUNS | YOU
_BEING = words(WORD_CLASSES["being"]) | {"s", "'s"}


def plain_phrases(sdc: SDC) -> SDC:
    """A clause whose phrases are plain ones, and those of the clauses inside."""
    sdc = replace(
        sdc,
        figure=tuple(map(plain_phrases, sdc.figure)),
        landmark1=tuple(map(plain_phrases, sdc.landmark1)),
        landmark2=tuple(map(plain_phrases, sdc.landmark2)),
    )
    sdc = replace(sdc, landmark1=_said_once(sdc.landmark1), landmark2=_said_once(sdc.landmark2))
    if sdc.type == "OBJECT":
        return _with_none(_beside_it(_without_copula(_aside(_turned_round(sdc)))))
    if sdc.type == "PLACE":
        return _on_top(_beside(_aside(sdc)))
    if sdc.type == "EVENT":
        return _picked_up_there(
            _one_place(_marks_aside(_being_there(_put_there(_with_side(_counted(sdc))))))
        )
    return sdc


def _said_once(parts: tuple[SDC, ...]) -> tuple[SDC, ...]:
    """One OBJECT where a second one says more of it: "the crate, the one by the gate"."""
    found: list[SDC] = []
    for part in parts:
        if found and _says_more(found[-1], part):
            found[-1] = replace(part, figure=(found[-1],))
        else:
            found.append(part)
    return tuple(found)


def _says_more(sdc: SDC, following: SDC) -> bool:
    """Whether an OBJECT is "the one" that another tells of, with nothing but a comma between."""
    if sdc.type != "OBJECT" or following.type != "OBJECT" or not following.figure:
        return False
    noun = noun_leaf(following).words
    if not (noun and ONES.intersection([_bare(noun[-1])])):
        return False
    return side_by_side(sdc, following, COMMA)


def _on_top(place: SDC) -> SDC:
    """A place that was spoken of, with its noun taken for a thing: "put it on top"."""
    mark = place.landmark1[0] if len(place.landmark1) == 1 else None
    if mark is None or not mark.is_leaf or {"top"} != {*map(_bare, mark.words)} - ARTICLES:
        return place
    return replace(place, relation=(*place.relation, *mark.words), landmark1=())


def _with_none(sdc: SDC) -> SDC:
    """A clause that says itself what there is not: "the truck with no crates"."""
    mark = next(iter(sdc.landmark1), None)
    if mark is None or len(mark.words) < 2 or HAVING.isdisjoint(map(_bare, sdc.relation)):
        return sdc
    no, *noun = mark.words
    if _bare(no) != "no":
        return sdc
    return replace(sdc, relation=(*sdc.relation, no), landmark1=(replace(mark, words=tuple(noun)),))


def _with_side(event: SDC) -> SDC:
    """A clause whose thing has the side that was taken for the verb's: "grab left crate"."""
    words = event.relation
    if len(words) < 2 or not event.landmark1 or event.landmark1[0].type != "OBJECT":
        return event
    theme, leaf = event.landmark1[0], noun_leaf(event.landmark1[0])
    if not leaf.words:
        return event
    beside = 0 < leaf.words[0].start - words[-1].end <= 1
    sides = concepts(field_words(words[-1:])) & SIDES
    verb = verb_of(tuple(map(_bare, words)))
    if not (beside and sides) or verb.classes != {"taking"} or _bare(leaf.words[0]) in _CLOSED:
        return event
    named = _replaced(theme, replace(leaf, words=(words[-1], *leaf.words)))
    return replace(event, relation=words[:-1], landmark1=(named, *event.landmark1[1:]))


def _replaced(sdc: SDC, leaf: SDC) -> SDC:
    """An OBJECT with another leaf for its noun."""
    return replace(sdc, figure=(_replaced(sdc.figure[0], leaf),)) if sdc.figure else leaf


def _counted(event: SDC) -> SDC:
    """A clause whose thing has what was taken for a way: "lift the second crate from the left"."""
    theme, way = next(iter(event.landmark1), None), next(iter(event.landmark2), None)
    if theme is None or way is None or len(event.landmark1) > 1 or way.landmark1:
        return event
    said = concepts(field_words(way.relation))
    ordinal = any(map(is_ordinal, field_words(noun_leaf(theme).words)))
    if not (theme.type == "OBJECT" and ordinal and "from" in said and said & SIDES):
        return event
    counted = SDC("OBJECT", relation=way.relation, figure=(theme,))
    return replace(event, landmark1=(counted,), landmark2=event.landmark2[1:])


def _marks_aside(event: SDC) -> SDC:
    """A clause whose landmark has the side behind it: "set it by the drum on the far left"."""
    found: list[SDC] = []
    for part in event.landmark2:
        if found and _tells_side(found[-1], part):
            mark = SDC("OBJECT", relation=part.relation, figure=found[-1].landmark1)
            found[-1] = replace(found[-1], landmark1=(mark,))
        else:
            found.append(part)
    return replace(event, landmark2=tuple(found))


def _tells_side(place: SDC, following: SDC) -> bool:
    """Whether a place's only landmark is followed at once by the side on which it is."""
    if len(place.landmark1) != 1 or following.landmark1 or following.type != "PLACE":
        return False
    (mark,) = place.landmark1
    said = concepts(field_words(following.relation))
    if not (said & SIDES and said & {"on", "to"}) or is_pronoun(mark) or is_floor(mark):
        return False
    return mark.type == "OBJECT" and side_by_side(place, following, len(" "))


def _put_there(event: SDC) -> SDC:
    """A clause that says where a thing goes, as nothing is told of "it" itself."""
    theme = next(iter(event.landmark1), None)
    if theme is None or theme.type != "OBJECT" or not (theme.figure and theme.landmark1):
        return event
    if len(event.landmark1) > 1 or not is_pronoun(theme.figure[0]):
        return event
    place = SDC("PLACE", relation=theme.relation, landmark1=theme.landmark1)
    return replace(event, landmark1=theme.figure, landmark2=(place, *event.landmark2))


def _being_there(event: SDC) -> SDC:
    """A clause whose theme is said to be somewhere: "lift whichever crate is by the gate"."""
    parts = (*event.landmark1, *event.landmark2)
    if [part.type for part in parts[:2]] != ["OBJECT", "PLACE"]:
        return event
    theme, place, *others = parts
    said = list(map(_bare, place.relation))
    where = concepts(field_words(place.relation))
    if not said or said[0] not in _BEING or not (where and place.landmark1):
        return event
    theme = replace(place, type="OBJECT", relation=place.relation[1:], figure=(theme,))
    return replace(event, landmark1=(theme,), landmark2=tuple(others))


def _without_copula(sdc: SDC) -> SDC:
    """The crate by the gate, where words say "the crate that is standing by the gate"."""
    said = list(map(_bare, sdc.relation))
    if not (sdc.figure and sdc.landmark1 and said) or said[0] not in RELATIVE:
        return sdc
    copula = next((i for i, word in enumerate(said[1:], 1) if word not in _BEING), len(said))
    if copula in (1, len(said)):
        return sdc
    return replace(sdc, relation=sdc.relation[copula:])


def _turned_round(sdc: SDC) -> SDC:
    """The crate beside the drum, where words say "the crate that the drum is standing beside"."""
    said = list(map(_bare, sdc.relation))
    if not sdc.figure or sdc.landmark1 or len(said) < 4 or said[0] not in RELATIVE:
        return sdc
    copula = next((i for i, word in enumerate(said) if word in _BEING), 1)
    if copula == 1 or not concepts(field_words(sdc.relation[-1:])) & (BESIDE | {"on"}):
        return sdc
    mark = SDC("OBJECT", words=sdc.relation[1:copula])
    rest = next((i for i, w in enumerate(said) if i > copula and w not in _BEING), len(said) - 1)
    return replace(sdc, relation=sdc.relation[rest:], landmark1=(mark,))


def _beside_it(sdc: SDC) -> SDC:
    """The crate beside the drum, where words say "the crate with a drum beside it"."""
    mark = next(iter(sdc.landmark1), None)
    if mark is None or HAVING.isdisjoint(map(_bare, sdc.relation)) or not mark.figure:
        return sdc
    if not (mark.landmark1 and is_pronoun(mark.landmark1[0]) and _says_beside(mark)):
        return sdc
    return replace(sdc, relation=mark.relation, landmark1=mark.figure)


def _aside(sdc: SDC) -> SDC:
    """A thing with its side as part of the relation, not as a landmark: "at the very back"."""
    mark = next(iter(sdc.landmark1), None)
    named = sdc.figure or sdc.type == "PLACE"
    if not named or mark is None or not (mark.is_leaf and sdc.relation):
        return sdc
    *before, noun = map(_bare, mark.words) if mark.words else ("",)
    own = ASIDE.intersection(before) if noun in HANDS else ASIDE.intersection((noun,))
    if not own or not (STRESSING | YOU | own).issuperset(before) or sdc.landmark2:
        return sdc
    return replace(sdc, relation=(*sdc.relation, *mark.words), landmark1=())


def _is_part(sdc: SDC) -> bool:
    """Whether a clause means a side or the middle: "on the near side, in front of the gate"."""
    noun = field_words(noun_leaf(sdc).words)[-1:]
    return sdc.type == "OBJECT" and bool(PARTS.intersection(noun) or "between" in concepts(noun))


def _says_beside(sdc: SDC) -> bool:
    """Whether a relation leads beside something, so that nothing is on top of it."""
    said = concepts(field_words(sdc.relation))
    return bool(sdc.landmark1) and bool(said & BESIDE) and "on" not in said


def _leads_beside(mark: SDC) -> bool:
    """The same for a part or the ground: "on the ground on the left of it" isn't on top of it."""
    return _says_beside(mark) or (is_floor(mark) and _has_side(mark))


def _has_side(sdc: SDC) -> bool:
    """Whether a relation names a side of its landmark: "on the left of it"."""
    return bool(sdc.landmark1) and not SIDES.isdisjoint(concepts(field_words(sdc.relation)))


def _beside(place: SDC) -> SDC:
    """A place beside something, where words say "on the ground beside it"."""
    place = _without_floor(place)
    if len(place.landmark1) != 1 or place.landmark2:
        return place
    (mark,) = place.landmark1
    if mark.figure and is_floor(mark) and len(mark.landmark1) == 1:
        mark = mark if _leads_beside(mark) else mark.landmark1[0]  # "in the middle between"
    if not (mark.figure and (is_floor(mark) or _is_part(mark)) and _leads_beside(mark)):
        return place
    return replace(
        place, relation=mark.relation, landmark1=mark.landmark1, landmark2=mark.landmark2
    )


def _without_floor(place: SDC) -> SDC:
    """A place that a tree has one with the ground: "on" the ground, "left of" the truck."""
    floors = [mark for mark in place.landmark1 if is_floor(mark) and mark.is_leaf]
    others = tuple(mark for mark in place.landmark1 if mark not in floors)
    if not (floors and others):
        return place
    start = all_words(floors[0])[0].start
    relation = tuple(word for word in place.relation if word.start > start)
    if not SIDES & concepts(field_words(relation)):
        return place
    return replace(place, relation=relation, landmark1=others)


def _one_place(event: SDC) -> SDC:
    """A clause without "on the ground", where another place is beside something."""
    arguments = (*event.landmark1, *event.landmark2)
    places = [part for part in arguments if part.type in ("PLACE", "PATH")]
    floors = [p for p in places if len(p.landmark1) == 1 and is_floor(p.landmark1[0])]
    if not any(_has_side(p) or _says_beside(p) for p in places if p not in floors):
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
    said = tuple(map(_bare, event.relation))
    verb = verb_of(said)
    arguments = (*event.landmark1, *event.landmark2)
    if verb.classes != {"taking"} or [part.type for part in arguments] != ["OBJECT", "PLACE"]:
        return event
    theme, place = arguments
    where = concepts(field_words(place.relation))
    brings = not BRINGING.isdisjoint(said) or not where & BESIDE
    leads = "to" in where and brings  # "lift it next to the gate" says where it is
    told = place.landmark1 or where & SIDES
    if theme.is_implicit or leads or not told or is_pronoun(theme):
        return event
    return replace(event, landmark1=(replace(place, type="OBJECT", figure=(theme,)),), landmark2=())
