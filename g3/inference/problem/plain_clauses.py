"""Clauses of a command in the form that frames and search read.

The parser learns plain trees, so little is left to do (``python -m benchmarks.written_commands
--ablations`` follows commands without it). Words are moved or left out, never made up, and a plain
clause stays as it is.

| function | example | read as |
| --- | --- | --- |
| `_unbroken` | turn clockwise (counter-) | turn counter-clockwise |
| `_to_speaker` | bring it to me | bring it to the person |
| `_whole` | back (to (the truck)) | back to (the truck) |
| `measures_apart` | 10 feet forward | forward (10 feet) |
| `_light` | make a left turn | turn left |
| `_for_each` | a drum and a crate on each truck | a drum on each truck; a crate on each truck |
| `_things_again` | a drum here, the same on the truck | …, a drum on the truck |
| `_same_place` | (the crate) on (the same truck) | (the crate) (on the same truck) |
| `_count_first` | crates x2 | x2 crates |
| `_staying` | stay there; wait for the boss, who isn't there | stay; wait for |
| `_onto` | load (the truck) (with the drum) | load (the drum) (the truck) |
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from g3.inference.problem.phrases import (
    arguments_of,
    is_measure,
    is_pronoun,
    is_there,
    names_forks,
    names_robot,
    side_by_side,
    subject_of,
    verb_words,
    whole_words,
    with_each,
)
from g3.inference.problem.world_nouns import Nouns
from g3.language.discourse.groups import noun_leaf, noun_words
from g3.language.lexicon.concepts import SIDES, concepts
from g3.language.lexicon.field_words import bare, bare_words, field_words, normalise
from g3.language.lexicon.measures import is_amount, metres_said, seconds_said
from g3.language.lexicon.tables import COUNTS, WORDS
from g3.language.lexicon.verb_chains import verb_of
from g3.language.lexicon.verb_classes import HANDLING_VERBS, word_class
from g3.language.similarity.presence import may_be_absent
from g3.sdc.clauses import SDC, Span, all_words
from g3.sdc.sdc_notation import IMPLICIT_FIGURE

PAIR = 2
MOST_AGAIN = 4
"""Words of "to the same place"."""
_HYPHENATED = re.compile(r"[^\W_]+(?:-[^\W_]+)+")


def plain(sdcs: Sequence[SDC], nouns: Nouns, text: str = "") -> tuple[SDC, ...]:
    """Return the clauses of a command as plain ones.

    Parameters
    ----------
    sdcs
        The top-level clauses.
    nouns
        What words may name in the world.
    text
        The command; empty where only its clauses are known.
    """
    whole = (_to_speaker(_whole(sdc), nouns) for sdc in _unbroken(sdcs, text))
    each = (own for sdc in whole for own in _for_each(_count_first(sdc, nouns)))
    return _things_again([_plain(sdc, nouns) for sdc in each])


def _plain(sdc: SDC, nouns: Nouns) -> SDC:
    if sdc.type != "EVENT":
        return sdc
    told = _staying(measures_apart(_light(_same_place(sdc, nouns))), nouns)
    told = _onto(told, nouns) or told
    first, second = (
        tuple(_plain(part, nouns) for part in own) for own in (told.landmark1, told.landmark2)
    )
    return replace(told, landmark1=first, landmark2=second)


def _unbroken(sdcs: Sequence[SDC], text: str) -> list[SDC]:
    """Clauses with hyphenated words as one, where their last part is: "counter-clockwise"."""
    starts = {word.start for sdc in sdcs for word in all_words(sdc)}
    whole: dict[int, Span] = {}
    parts: set[int] = set()
    for match in _HYPHENATED.finditer(text):
        inside = starts.intersection(range(match.start(), match.end()))
        if inside:
            whole[max(inside)] = Span(match.start(), match.group())
            parts |= inside

    def joined(words: Sequence[Span]) -> tuple[Span, ...]:
        kept = (word for word in words if word.start not in parts or word.start in whole)
        return tuple(whole.get(word.start, word) for word in kept)

    def mended(sdc: SDC) -> tuple[SDC, ...]:
        own = replace(sdc, words=joined(sdc.words), relation=joined(sdc.relation))
        figure, first, second = (
            tuple(new for part in field for new in mended(part))
            for field in (sdc.figure, sdc.landmark1, sdc.landmark2)
        )
        own = replace(own, figure=figure, landmark1=first, landmark2=second)
        return (own,) if sdc.is_implicit or all_words(own) else ()

    return [new for sdc in sdcs for new in mended(sdc)] if whole else list(sdcs)


def _to_speaker(sdc: SDC, nouns: Nouns) -> SDC:
    """A clause with who speaks as a person, where one is to be seen: "bring it [to me]".

    Otherwise the speaker stands by the robot.
    """
    if not nouns.people:
        return sdc
    led = sdc.landmark2 if any(part.type == "OBJECT" for part in sdc.landmark1) else ()
    given = [part for part in led if sdc.type == "EVENT" and _is_speaker(part)]
    to_me = bool(given) or any(
        map(_is_speaker, (m for p in arguments_of(sdc) for m in p.landmark1))
    )
    first, second = (
        tuple(
            _to(_as_person(part)) if part in given else _to_speaker(_as_person(part), nouns)
            for part in own
            if not (to_me and _is_here(part))
        )
        for own in (sdc.landmark1, sdc.landmark2)
    )
    return replace(sdc, landmark1=first, landmark2=second)


def _to(sdc: SDC) -> SDC:
    return SDC("PATH", (), (Span(sdc.words[0].start, "to"),), landmark1=(sdc,))


def _is_here(sdc: SDC) -> bool:
    """Check that a clause says no more than "here"."""
    return not sdc.landmark1 and bare_words(all_words(sdc))[-1:] == ["here"]


def _as_person(sdc: SDC) -> SDC:
    """An OBJECT that is who speaks as a person; any other clause as it is."""
    if not _is_speaker(sdc):
        return sdc
    return SDC("OBJECT", words=(replace(all_words(sdc)[0], text="person"),))


def _is_speaker(sdc: SDC) -> bool:
    """Check that a landmark is who speaks, or where: "me", "my feet", "where [I am]"."""
    if sdc.type == "EVENT":
        subject, said = subject_of(sdc), verb_words(sdc)
        is_there_now = {"staying", "being"}.intersection(
            word_class(said[-1] if said else "").split("+")
        )
        stands = bool(is_there_now) or WORDS["stating"].issuperset(said)
        return subject is not None and not arguments_of(sdc) and stands and _is_speaker(subject)
    words = bare_words(sdc.words)
    own = words[:1] == ["my"] and WORDS["body"].issuperset(words[1:])
    return sdc.type == "OBJECT" and bool(words) and (own or WORDS["speaker"].issuperset(words))


def _whole(sdc: SDC) -> SDC:
    """A clause whose relation has whole words: "counter-clockwise" is one.

    A way within a way is one: "back [to the truck]". One without words is what is come to: "pass
    [the truck]".
    """
    sdc = with_each(sdc, _whole)
    sdc = replace(sdc, words=tuple(word for word in sdc.words if bare(word.text)))
    inner = sdc.landmark1[0] if len(sdc.landmark1) == 1 and not sdc.landmark2 else None
    if inner is not None and inner.type == "PATH" and inner.landmark1:
        if sdc.type == "EVENT" and sdc.relation and not (inner.relation or subject_of(sdc)):
            return replace(sdc, landmark1=inner.landmark1)
        if sdc.type == "PATH":
            relation = (*sdc.relation, *inner.relation)
            return replace(inner, relation=whole_words(tuple(sorted(relation))))
    return replace(sdc, words=whole_words(sdc.words), relation=whole_words(sdc.relation))


def _light(sdc: SDC) -> SDC:
    start = verb_of(tuple(verb_words(sdc))).start
    noun, *others = arguments_of(sdc) or (None,)
    said = whole_words(noun.words) if noun is not None and noun.type == "OBJECT" else ()
    own = bare_words(said)
    if WORDS["light"].isdisjoint(verb_words(sdc)[start : start + 1]) or len(own) < 2:
        return sdc
    acts = verb_of((own[-1],)).classes or own[1:] in (["left"], ["right"])
    if own[0] not in WORDS["an"] or not acts:
        return sdc
    relation = (*sdc.relation[:start], said[-1], *said[1:-1], *sdc.relation[start + 1 :])
    return replace(sdc, relation=relation, landmark1=tuple(others[:1]), landmark2=tuple(others[1:]))


def _for_each(sdc: SDC) -> tuple[SDC, ...]:
    """A clause for each of several things that each goal takes: "a drum, a crate on each truck"."""
    things = [part for part in sdc.landmark1 if part.type == "OBJECT"]
    goals = [part for part in arguments_of(sdc) if part.type in ("PLACE", "PATH")]
    marks = [mark for goal in goals for mark in goal.landmark1]
    each = any(not WORDS["distributive"].isdisjoint(noun_words(mark)[:1]) for mark in marks)
    if sdc.type != "EVENT" or len(things) < PAIR or not each:
        return (sdc,)
    others = tuple(part for part in sdc.landmark1 if part not in things)
    return tuple(replace(sdc, landmark1=(thing, *others)) for thing in things)


def _things_again(sdcs: Sequence[SDC]) -> tuple[SDC, ...]:
    """Return clauses where "the same" is things like those of the clause before."""
    found: list[SDC] = []
    for sdc in sdcs:
        again = bool(found) and _names_the_same(sdc)
        found.append(_with_things_of(found[-1], sdc) if again else sdc)
    return tuple(found)


def _names_the_same(sdc: SDC) -> bool:
    """Check that a clause leads things like those before elsewhere: "the same on the truck"."""
    things = [p for p in (subject_of(sdc), *arguments_of(sdc)) if p and p.type == "OBJECT"]
    leads = any(part.type in ("PLACE", "PATH") for part in arguments_of(sdc))
    same = [
        word
        for thing in things
        for word in bare_words(all_words(thing))
        if word not in WORDS["articles"]
    ]
    return sdc.type == "EVENT" and leads and same == ["same"]


def _with_things_of(before: SDC, sdc: SDC) -> SDC:
    """A clause about things like those of the clause before."""
    goals = tuple(part for part in arguments_of(sdc) if part.type != "OBJECT")
    subject = subject_of(before)
    if subject is not None and not names_robot(subject):
        return replace(before, landmark1=goals, landmark2=())
    things = tuple(part for part in before.landmark1 if part.type == "OBJECT")
    return replace(before, landmark1=things, landmark2=goals)


def _same_place(event: SDC, nouns: Nouns) -> SDC:
    """A clause whose only goal is the one before: "in the same spot", "same truck"."""

    def again(part: SDC) -> bool:
        goes = part in event.landmark2 or part.type != "OBJECT"
        return goes and _says_same_place(all_words(part), nouns)

    def goal(part: SDC) -> SDC:
        return SDC("PLACE", relation=tuple(sorted(all_words(part)))) if again(part) else part

    others = [p for p in arguments_of(event) if p.type in ("PLACE", "PATH") and not again(p)]
    first, second = (tuple(map(goal, own)) for own in (event.landmark1, event.landmark2))
    if not others:
        return replace(event, landmark1=first, landmark2=second)
    first, second = (
        tuple(p for p in own if p.landmark1 or verb_words(p) != ["together"])
        for own in (event.landmark1, event.landmark2)
    )
    return replace(event, landmark1=first, landmark2=second)


def _says_same_place(said: Sequence[Span], nouns: Nouns) -> bool:
    words = bare_words(said)
    is_place = not WORDS["areas"].isdisjoint(field_words(said)) or nouns.name_other(said[-1:])
    return is_place and "same" in words and len(words) <= MOST_AGAIN


def _count_first(sdc: SDC, nouns: Nouns) -> SDC:
    """Return a clause with the counts of its loads before their nouns."""
    sdc = with_each(sdc, lambda part: _count_first(part, nouns))
    said = bare_words(sdc.words)
    last = said[-1] if len(said) > 1 else ""
    counts = last in COUNTS["counts"] or (last.strip("x×").isdecimal() and not last.isdecimal())
    if counts and nouns.name_load(sdc.words[-2:-1]):
        return replace(sdc, words=(sdc.words[-1], *sdc.words[:-1]))
    return sdc


def _staying(sdc: SDC, nouns: Nouns) -> SDC:
    """A clause that asks to wait, without what isn't there, or to turn, without "on the spot"."""
    parts, classes = arguments_of(sdc), verb_of(tuple(verb_words(sdc))).classes
    if not classes & {"staying", "turning"} or subject_of(sdc):
        return sdc
    waits = "staying" in classes
    if waits and any(p.type == "OBJECT" and not _names_nothing(p, nouns) for p in parts):
        return sdc
    aside = {
        part
        for part in parts
        if (_names_nothing(part, nouns) or is_there(part) if waits else _is_where_it_is(part))
    }
    first, second = (
        tuple(part for part in own if part not in aside) for own in (sdc.landmark1, sdc.landmark2)
    )
    return replace(sdc, landmark1=first, landmark2=second)


def _is_where_it_is(part: SDC) -> bool:
    """Check that a place is where the robot is: "on the spot"."""
    at = part.type == "PLACE" and bool(part.landmark1)
    return at and WORDS["start"].issuperset(bare_words(all_words(part)))


def _names_nothing(sdc: SDC, nouns: Nouns) -> bool:
    """Check that a clause is an OBJECT that names nothing that there is: "a bit quick"."""
    if sdc.type != "OBJECT":
        return False
    words = noun_leaf(sdc).words[-1:]
    said = bare_words(words)
    if not said or sdc.figure or not may_be_absent(said[0]):
        return bool(said) and said[0] in WORDS["manners"]
    return not (nouns.name_load(words) or nouns.name_other(words))


def _onto(sdc: SDC, nouns: Nouns) -> SDC | None:
    """A clause with loads, and what takes them as their goal: "load the truck with the drum"."""
    parts, needs, said = arguments_of(sdc), subject_of(sdc), verb_words(sdc)
    fills = not WORDS["filling"].isdisjoint(said)
    wants = not WORDS["asking"].isdisjoint(map(normalise, said))
    if needs is not None and wants and not names_robot(needs):  # "the truck needs the drum"
        parts = (needs, *parts)
    elif len(parts) == 1 and fills and parts[0].figure and verb_words(parts[0]) == ["with"]:
        parts = (*parts[0].figure, *parts[0].landmark1)
    elif not (fills or verb_of(tuple(said)).classes <= HANDLING_VERBS):
        return None
    loads = [load for part in parts for load in _given(part, nouns)]
    carriers = [part for part in parts if not _given(part, nouns)]
    if not loads or len(carriers) != 1 or carriers[0].type != "OBJECT":
        return None
    if not (is_pronoun(carriers[0]) or _names_other(carriers[0], nouns)):
        return None
    place = SDC("PLACE", landmark1=(carriers[0],))
    return replace(sdc, figure=IMPLICIT_FIGURE, landmark1=tuple(loads), landmark2=(place,))


def _given(part: SDC, nouns: Nouns) -> tuple[SDC, ...]:
    """The loads of an argument: "the drum", or "with the drum"."""
    if part.type == "OBJECT":
        return (part,) if _names_load(part, nouns) else ()
    loads = [noun_leaf(mark).words for mark in part.landmark1]
    gives = verb_words(part) == ["with"] and all(map(nouns.name_load, loads))
    return part.landmark1 if gives else ()


def _names_other(sdc: SDC, nouns: Nouns) -> bool:
    return nouns.name_other(noun_leaf(sdc).words)


def _names_load(sdc: SDC, nouns: Nouns) -> bool:
    return nouns.name_load(noun_leaf(sdc).words)


_Apart = tuple[SDC | None, tuple[Span, ...]]
"""Argument that stays in a clause, and the words that become the clause's own."""


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
        if before is not None and leads and side_by_side(before, part, len(" ")):
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
