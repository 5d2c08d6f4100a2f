"""Clauses of a command as plain ones: what is done, to what, and where to.

The parser learns plain trees, so little is left to do (``python -m benchmarks.written_commands
--ablations`` follows commands without it). Words are moved or left out, never made up, and a plain
clause stays as it is.

| function | example | read as |
| --- | --- | --- |
| `_unbroken` | turn clockwise (counter-) | turn counter-clockwise |
| `restored` | far tires, truck | far tires (to the truck) |
| `_in_order` | return after placing the drum | placing the drum; return |
| `_for_each` | a drum and a crate on each truck | a drum on each truck; a crate on each truck |
| `_without_empty_it` | back it up, where nothing was spoken of | back up |
| `_fronted` | goes (the drum) (to the gate), named in this order | (the drum) goes (to the gate) |
| `_one_place` | put it on the ground by the gate | put it by the gate |
| `_noun_last` | crates x2; crates, the far ones | x2 crates; the far crates |
| `_each_apart` | (drums and crates by the gate) | (drums by the gate) (crates by the gate) |
| `_from_there` | put (the drum) (off the floor) (there) | put (the drum off the floor) (there) |
| `_noun_apart` | crate (near gate), all its own words | crate near (gate) |
| `_aside` | the drum on (the far left) | the drum (on the far left) |
| `_one_deck` | put the drum on the floor on the truck | put (drum on the floor) (on the truck) |
| `measures_apart` | 10 feet forward | forward (10 feet) |
| `_light` | make a left turn | turn left |
| `_joining` | the drum may join them | may (the drum) (join them) |
| `_staying` | stay there; wait for the boss, who isn't there | stay; wait for |
| `_onto` | load (the truck) (with the drum) | load (the drum) (the truck) |
| `_result` | I want the drum on the truck, where it isn't | I want (the drum) (on the truck) |
| `without_statements` | there are two crates by the gate. Lift one | lift one |
| `repeated` | put the drum on the truck, then the crate | …, then put the crate on the truck |
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from g3.inference.problem.clause_roles import is_goal, is_source
from g3.inference.problem.ellipsis import repeated, restored
from g3.inference.problem.phrases import (
    arguments_of,
    is_floor,
    is_measure,
    is_pronoun,
    is_there,
    names_forks,
    names_held,
    names_robot,
    only_object,
    side_by_side,
    subject_of,
    verb_words,
    whole_words,
    with_each,
)
from g3.inference.problem.statements import names_nothing, without_statements
from g3.inference.problem.world_nouns import Nouns
from g3.language.discourse.groups import noun_leaf, noun_words
from g3.language.lexicon.concepts import BESIDE, SIDES, concepts
from g3.language.lexicon.field_words import bare, bare_words, field_words, normalise
from g3.language.lexicon.measures import is_amount, metres_said, seconds_said
from g3.language.lexicon.tables import COUNTS, WORDS
from g3.language.lexicon.verb_chains import verb_of
from g3.language.lexicon.verb_classes import HANDLING_VERBS, word_class
from g3.sdc.clauses import SDC, Span, all_words
from g3.sdc.sdc_notation import IMPLICIT_FIGURE

_HYPHENATED = re.compile(r"[^\W_]+(?:-[^\W_]+)+")
PAIR = 2
MOST_AGAIN = 4
"""Words of "to the same place"."""


def plain(sdcs: Sequence[SDC], nouns: Nouns, text: str = "") -> tuple[SDC, ...]:
    """The clauses of a command as plain ones, without those that ask for nothing.

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
    each = [own for sdc in whole for part in _in_order(sdc) for own in _for_each(part)]
    told = _without_empty_it(restored(each, text, nouns), nouns)
    fronted = [_fronted(sdc) for sdc in told]
    phrased = [
        _with_plain_phrases(
            sdc, nouns, aside=not any(_has_side_goal(b, nouns) for b in fronted[:i])
        )
        for i, sdc in enumerate(fronted)
    ]
    asking = without_statements(phrased, nouns)
    return repeated([_plain(sdc, nouns) for sdc in asking], nouns)


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


def _in_order(sdc: SDC) -> tuple[SDC, ...]:
    """Return what is to be done before a clause, and it: "return after placing the crate"."""
    first = [part for part in sdc.landmark2 if part.type == "EVENT" and _is_before(part)]
    if sdc.type != "EVENT" or not first:
        return (sdc,)
    rest = tuple(part for part in sdc.landmark2 if part not in first)
    return (*(inner for part in first for inner in part.landmark1), replace(sdc, landmark2=rest))


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


def _is_before(sdc: SDC) -> bool:
    """Check that a clause says what is to be done first: "after having placed the crate"."""
    after = verb_words(sdc) in (["after"], ["once"])
    inner = sdc.landmark1[0] if len(sdc.landmark1) == 1 else None
    if not after or inner is None or inner.type != "EVENT" or subject_of(inner):
        return False
    return bool(verb_of(tuple(verb_words(inner))).classes & HANDLING_VERBS and arguments_of(inner))


def _without_empty_it(sdcs: Sequence[SDC], nouns: Nouns) -> list[SDC]:
    """Clauses of going without an "it" that can stand for nothing: "back it up ten feet"."""
    found: list[SDC] = []
    for i, sdc in enumerate(sdcs):
        things = [part for part in arguments_of(sdc) if part.type == "OBJECT"]
        moves = {"going", "turning"} & verb_of(tuple(verb_words(sdc))).classes
        alone = sdc.type == "EVENT" and bool(things) and all(map(_is_it_or_measure, things))
        spoken = nouns.state.held is not None or any(map(_names_something, sdcs[:i]))
        if moves and alone and not spoken:
            first, second = (
                tuple(part for part in own if not is_pronoun(part))
                for own in (sdc.landmark1, sdc.landmark2)
            )
            sdc = replace(sdc, landmark1=first, landmark2=second)  # noqa: PLW2901
        found.append(sdc)
    return found


def _is_it_or_measure(sdc: SDC) -> bool:
    return is_pronoun(sdc) or is_measure(sdc)


def _names_something(sdc: SDC) -> bool:
    own = sdc.type == "OBJECT" and bool(sdc.words) and not is_pronoun(sdc) and not is_measure(sdc)
    return own or any(map(_names_something, sdc.children()))


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


def _with_plain_phrases(sdc: SDC, nouns: Nouns, *, aside: bool = True) -> SDC:
    """Return a clause with plain phrases; `aside` is False where "the right" may be a truck."""
    is_event = sdc.type == "EVENT"
    inner = with_each(
        sdc, lambda part: _with_plain_phrases(part, nouns, aside=aside or not is_event)
    )
    sdc = _noun_last(inner, nouns)
    if is_event:
        apart = _same_place(_each_apart(sdc, nouns), nouns)
        return _one_place(_one_deck(_from_there(apart)))
    sdc = _noun_apart(sdc, nouns)
    return _aside(sdc) if aside else sdc


def _noun_apart(sdc: SDC, nouns: Nouns) -> SDC:
    """A way whose landmark is among its own words: "near sign", "left trailer"."""
    if sdc.type not in ("PLACE", "PATH") or sdc.landmark1 or not sdc.relation:
        return sdc
    last = sdc.relation[-1:]
    if concepts(field_words(last)) or not nouns.name_other(last):
        return sdc
    return _split(sdc)


def _split(sdc: SDC) -> SDC:
    """A way with the words behind its last preposition as its landmark."""
    said = bare_words(sdc.relation)
    start = max((i for i, w in enumerate(said) if w in WORDS["place_prepositions"]), default=-1) + 1
    if start == len(sdc.relation):
        return sdc
    mark = SDC("OBJECT", words=sdc.relation[start:])
    return replace(sdc, relation=sdc.relation[:start], landmark1=(mark,))


def _goes_along(sdc: SDC) -> bool:
    """Check that words join one thing to another: "along with", "plus", "together with"."""
    said = set(verb_words(sdc))
    return said <= WORDS["company"] and said not in (set(), {"with"}, {"right"})


def _from_there(event: SDC) -> SDC:
    """A clause whose load is told by where it is: "put the crate off the floor there"."""
    parts = arguments_of(event)
    sources = [p for p in parts if p.type in ("PLACE", "PATH") and p.landmark1 and is_source(p)]
    goals = [p for p in parts if p.type in ("PLACE", "PATH") and p not in sources]
    themes = [part for part in parts if part.type == "OBJECT"]
    if len(sources) != 1 or not goals or len(themes) != 1 or themes[0].landmark1:
        return event
    if is_pronoun(themes[0]):
        return event
    (source,), (theme,) = sources, themes
    load = SDC("OBJECT", (), source.relation, (theme,), source.landmark1)
    first, second = (
        tuple(load if part is theme else part for part in own if part is not source)
        for own in (event.landmark1, event.landmark2)
    )
    return replace(event, landmark1=first, landmark2=second)


def _has_side_goal(sdc: SDC, nouns: Nouns) -> bool:
    """Check that a clause leads to one of several things: "to the left truck", "on each truck"."""
    goals = [part for part in arguments_of(sdc) if part.type in ("PLACE", "PATH")]
    leaves = [noun_leaf(mark).words for part in goals for mark in part.landmark1]
    one_of = WORDS["distributive"]
    return sdc.type == "EVENT" and any(
        nouns.name_other(words)
        and (
            concepts(field_words(words)) & {"left", "right", "between"}
            or one_of & {*bare_words(words)}
        )
        for words in leaves
        if words
    )


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


def _each_apart(event: SDC, nouns: Nouns) -> SDC:
    """A clause with things that share what is said of them each on its own: "A and B on it"."""

    def apart(part: SDC) -> tuple[SDC, ...]:
        if part.type != "OBJECT" or not part.figure:
            return (part,)
        if _goes_along(part):
            return (*part.figure, *part.landmark1)
        if not part.landmark1 and _says_same_place(part.relation, nouns):
            return (*part.figure, SDC("PLACE", relation=part.relation))
        if len(part.figure) < PAIR or not part.landmark1:
            return (part,)
        return tuple(replace(part, figure=(own,)) for own in part.figure)

    figure, first = (
        tuple(own for part in parts for own in apart(part))
        for parts in (event.figure, event.landmark1)
    )
    return replace(event, figure=figure, landmark1=first)


def _noun_last(sdc: SDC, nouns: Nouns) -> SDC:
    """A leaf with its noun at the end: "crates x2", "crates, the far ones"."""
    said = bare_words(sdc.words)
    last = said[-1] if len(said) > 1 else ""
    if last in WORDS["ones"] and not WORDS["articles"].isdisjoint(said[1:]):
        start = max(i for i, word in enumerate(said) if word in WORDS["articles"])
        head = [w for w in sdc.words[:start] if bare(w.text) not in WORDS["articles"]]
        if head and bare(head[-1].text) not in WORDS["nounless"]:
            return replace(sdc, words=(*sdc.words[start:-1], *head))
    counts = last in COUNTS["counts"] or (last.strip("x×").isdecimal() and not last.isdecimal())
    if counts and nouns.name_load(sdc.words[-2:-1]):
        return replace(sdc, words=(sdc.words[-1], *sdc.words[:-1]))
    return sdc


def _aside(sdc: SDC) -> SDC:
    """A clause whose landmark is only a side, as words of its relation: "on the far left"."""
    mark = sdc.landmark1[0] if len(sdc.landmark1) == 1 and not sdc.landmark2 else None
    if mark is None or not (mark.words and sdc.relation):
        return sdc
    words = bare_words(mark.words)
    telling = set(words) - WORDS["articles"] - WORDS["stressing"] - {"far", "side"}
    if not telling or words[-1] not in {*telling, "side"} or not telling <= WORDS["side_nouns"]:
        return sdc
    return replace(sdc, relation=tuple(sorted((*sdc.relation, *mark.words))), landmark1=())


def _plain(sdc: SDC, nouns: Nouns) -> SDC:
    if sdc.type != "EVENT":
        return sdc
    told = measures_apart(_light(_without_times(sdc, nouns)))
    sdc = _up_or_off(_staying(_joining(told), nouns), nouns)
    for moved in (_onto, _result):
        sdc = moved(sdc, nouns) or sdc
    first, second = (
        tuple(_plain(part, nouns) for part in own) for own in (sdc.landmark1, sdc.landmark2)
    )
    return replace(sdc, landmark1=first, landmark2=second)


def _without_times(sdc: SDC, nouns: Nouns) -> SDC:
    """A clause without when or why it is said: "before noon", "by the time I'm done"."""
    first, second = (
        tuple(part for part in own if not _is_time(part, nouns))
        for own in (sdc.landmark1, sdc.landmark2)
    )
    return replace(sdc, landmark1=first, landmark2=second)


def _is_time(part: SDC, nouns: Nouns) -> bool:
    """Check that an argument is an EVENT that neither ends what is done nor names what there is."""
    if (
        part.type != "EVENT"
        or not part.relation
        or not WORDS["when_or_why"].issuperset(verb_words(part))
    ):
        return False
    return not any(_names_a_thing(inner, nouns) for inner in part.children())


def _names_a_thing(sdc: SDC, nouns: Nouns) -> bool:
    return any(map(nouns.name_thing, sdc.words)) or any(
        _names_a_thing(part, nouns) for part in sdc.children()
    )


def _up_or_off(sdc: SDC, nouns: Nouns) -> SDC:
    """A clause with the ways of its loads apart: "crates on, tires off", "put the crate on".

    Without a landmark "up" is on what carries them.
    """
    subject = subject_of(sdc)
    things = tuple(part for part in sdc.landmark1 if part.type == "OBJECT")
    moved = things if subject is None else (subject,)
    if not moved or not all(_names_load(part, nouns) or is_pronoun(part) for part in moved):
        return sdc
    if subject is None and sdc.relation:
        ways_alone = WORDS["ways_of_loads"].issuperset(verb_words(sdc))
        on = tuple(word for word in sdc.relation[1:] if bare(word.text) == "on")
        way = sdc.relation if ways_alone else on
        if not way or not (ways_alone or arguments_of(sdc) == things):
            return sdc
        rest = tuple(word for word in sdc.relation if word not in way)
        place = SDC("PATH" if _leads_off(bare_words(way)) else "PLACE", (), way)
        sdc = replace(sdc, relation=rest, landmark2=(place, *sdc.landmark2))
        if rest:
            return sdc
    ways = [_aboard(part) for part in arguments_of(sdc) if part not in moved]
    if any(is_source(part) and part.landmark1 for part in ways):  # "down" "from the truck"
        ways = [part for part in ways if part.landmark1 or not _leads_off(verb_words(part))]
    off = any(is_source(part) or _leads_off(verb_words(part)) for part in ways)
    if off and not any(is_goal(part) or part.type == "PLACE" for part in ways):
        come = sdc.relation or (Span(all_words(sdc)[0].start, "come"),)
        return replace(sdc, figure=moved, relation=come, landmark1=tuple(ways), landmark2=())
    own = moved if subject is None else ()
    return replace(sdc, landmark1=(*own, *ways), landmark2=())


def _leads_off(words: Sequence[str]) -> bool:
    return bool(words) and {"off", "down"}.issuperset(words)


def _aboard(part: SDC) -> SDC:
    """A way up without a landmark as the place on top; others as they are."""
    if part.landmark1 or part.type not in ("PATH", "PLACE") or verb_words(part) != ["up"]:
        return part
    return SDC("PLACE", (), (replace(part.relation[0], text="on"),))


def _fronted(sdc: SDC) -> SDC:
    """A clause with what stands before a verb of going as its subject."""
    first = sdc.landmark1[0] if sdc.type == "EVENT" and sdc.landmark1 else None
    if first is None or first.type != "OBJECT" or not sdc.relation or subject_of(sdc):
        return sdc
    goes = verb_of(tuple(verb_words(sdc))).classes == {"going"}
    words = all_words(first)
    leads = goes and words and words[-1].start < sdc.relation[-1].start
    if not leads or names_robot(first) or is_measure(first):
        return sdc
    fronted = [part for part in sdc.landmark1 if part.type == "OBJECT"]
    rest = tuple(part for part in sdc.landmark1 if part not in fronted)
    return replace(sdc, figure=tuple(fronted), landmark1=rest)


def _says_beside(sdc: SDC) -> bool:
    """Check that a relation leads beside something, so that nothing is on top of it."""
    said = concepts(field_words(sdc.relation))
    return bool(sdc.landmark1) and bool(said & BESIDE) and "on" not in said


def _one_deck(event: SDC) -> SDC:
    parts = arguments_of(event)
    if [part.type for part in parts] != ["OBJECT", "PLACE", "PLACE"] or is_pronoun(parts[0]):
        return event
    theme, first, second = parts
    if not all(p.landmark1 and verb_words(p) == ["on"] for p in (first, second)):
        return event
    noun = SDC("OBJECT", (), first.relation, (theme,), first.landmark1)
    return replace(event, landmark1=(noun,), landmark2=(second,))


def _one_place(event: SDC) -> SDC:
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


def _has_side(sdc: SDC) -> bool:
    """Check that a relation names a side of its landmark: "on the left of it"."""
    return bool(sdc.landmark1) and not SIDES.isdisjoint(concepts(field_words(sdc.relation)))


def _has(place: SDC) -> bool:
    """Check that a place is at a thing that has something: "on the truck that has a crate"."""
    return any(not WORDS["having"].isdisjoint(verb_words(mark)) for mark in place.landmark1)


def _is_on_it(place: SDC) -> bool:
    """Check that a place is on the thing just named: "on it"."""
    marks = [bare(word.text) for mark in place.landmark1 for word in all_words(mark)]
    return bool(marks) and WORDS["it"].issuperset(marks) and "on" in verb_words(place)


def _result(sdc: SDC, nouns: Nouns) -> SDC | None:
    parts = arguments_of(sdc)
    objects_alone = parts == sdc.landmark1 and all(part.type == "OBJECT" for part in parts)
    theme = parts[-1] if parts and objects_alone else only_object(sdc)
    if theme is None or len(theme.figure) != 1 or len(theme.landmark1) != 1:
        return None
    if not WORDS["class/relative"].isdisjoint(verb_words(theme)):
        return None
    said = concepts(field_words(theme.relation))
    own = verb_words(sdc)
    classes = verb_of(tuple(own)).classes
    gets = not WORDS["getting"].isdisjoint(own) and nouns.name_other(
        noun_leaf(theme.landmark1[0]).words
    )
    wants = not own or not WORDS["asking"].isdisjoint(map(normalise, own)) or gets
    puts = classes in ({"placing"}, {"carrying"})
    where = puts and "down" not in own if said & BESIDE else "on" in said
    if not where or "from" in said or not (wants or classes in ({"placing"}, {"carrying"})):
        return None
    one, other = (
        field_words(noun_leaf(part).words) for part in (theme.figure[0], theme.landmark1[0])
    )
    loads = nouns.name_load(noun_leaf(theme.figure[0]).words) or names_held(theme.figure[0])
    if nouns.stands_on(one, other) or not loads:
        return None
    place = SDC("PLACE", relation=theme.relation, landmark1=theme.landmark1)
    before = parts[:-1] if objects_alone else ()
    return replace(sdc, landmark1=(*before, *theme.figure), landmark2=(place,))


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


def _joining(sdc: SDC) -> SDC:
    """A clause whose verb leads to where something else goes: "the crate may join them"."""
    parts = arguments_of(sdc)
    subject = subject_of(sdc)
    things = [part for part in parts if part.type == "OBJECT" and not is_pronoun(part)]
    theme = subject if subject is not None and not things else next(iter(things), None)
    others = tuple(part for part in parts if part is not theme)
    joined = WORDS["accompanying"] if others else WORDS["accompanying"] - {"with"}
    way = tuple(word for word in sdc.relation if bare(word.text) in joined)
    if theme is None or not way or names_robot(theme) or not all(map(is_pronoun, others)):
        return sdc
    rest = tuple(word for word in sdc.relation if word not in way)
    place = SDC("PLACE", relation=way, landmark1=others)
    first = (theme,) if subject is None else ()
    return replace(sdc, relation=rest, landmark1=(*first, place), landmark2=())


def _staying(sdc: SDC, nouns: Nouns) -> SDC:
    """A clause that asks to wait, without what isn't there, or to turn, without "on the spot"."""
    parts, classes = arguments_of(sdc), verb_of(tuple(verb_words(sdc))).classes
    if not classes & {"staying", "turning"} or subject_of(sdc):
        return sdc
    waits = "staying" in classes
    if waits and any(p.type == "OBJECT" and not names_nothing(p, nouns) for p in parts):
        return sdc
    aside = {
        part
        for part in parts
        if (names_nothing(part, nouns) or is_there(part) if waits else _is_where_it_is(part))
    }
    first, second = (
        tuple(part for part in own if part not in aside) for own in (sdc.landmark1, sdc.landmark2)
    )
    return replace(sdc, landmark1=first, landmark2=second)


def _is_where_it_is(part: SDC) -> bool:
    """Check that a place is where the robot is: "on the spot"."""
    at = part.type == "PLACE" and bool(part.landmark1)
    return at and WORDS["start"].issuperset(bare_words(all_words(part)))


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
