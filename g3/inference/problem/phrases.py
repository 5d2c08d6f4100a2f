"""Kinds of phrases: a noun's complement, an area, "there"."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from difflib import get_close_matches

from g3.features.sets.order import is_ordinal
from g3.language.discourse.groups import group, noun_leaf
from g3.language.lexicon.concepts import BESIDE, SIDES, concepts
from g3.language.lexicon.field_words import bare_words, field_words, figure_words, normalise
from g3.language.lexicon.measures import is_amount
from g3.language.lexicon.tables import COUNTS, WORDS
from g3.language.lexicon.verb_classes import word_class
from g3.sdc.clauses import SDC, SDCType, Span, all_words

ALIKE = 0.8
"""Words so alike are one, misspelt (:mod:`difflib`)."""


def is_complement(sdc: SDC) -> bool:
    """Check that an OBJECT's landmark names the same thing: "the pallet of tires"."""
    return sdc.type == "OBJECT" and field_words(sdc.relation) == ("of",)


def is_area(sdc: SDC) -> bool:
    """Check that an OBJECT is a place: "the floor", "the space between the pallets"."""
    if sdc.type != "OBJECT" or is_complement(sdc):
        return False
    noun = field_words(noun_leaf(sdc).words)
    return bool((WORDS["areas"] if sdc.landmark1 else WORDS["floor"]).intersection(noun))


def names_thing(sdc: SDC) -> bool:
    """Check that an OBJECT's noun names things, not a place."""
    return not WORDS["areas"].intersection(figure_words(sdc))


def is_measure(sdc: SDC) -> bool:
    """Check that an OBJECT tells how far, and names nothing: "a bit", "two squares"."""
    words = bare_words(sdc.words)
    if sdc.type != "OBJECT" or not words or words[0] == "the":
        return False
    return "measure" in word_class(words[-1]).split("+") or is_amount(words)


def factor_type(sdc: SDC) -> SDCType:
    """The type of a clause's factor: where an area is tells a PLACE's."""
    return "PLACE" if is_area(sdc) else sdc.type


def is_bare(sdc: SDC) -> bool:
    """Check that an OBJECT names one thing by nothing but its kind: "the pallet of tires"."""
    return sdc.type == "OBJECT" and not is_singled_out(sdc) and group(sdc).number == "singular"


def is_floor(sdc: SDC) -> bool:
    """Check that a clause means the ground alone."""
    return sdc.type == "OBJECT" and bool(
        WORDS["floor"].intersection(field_words(noun_leaf(sdc).words))
    )


def is_uncounted(sdc: SDC) -> bool:
    """Check that an OBJECT names by its kind one thing or what counts as one: "the tires"."""
    said = group(sdc)
    if sdc.type != "OBJECT" or is_singled_out(sdc):
        return False
    return said.number == "singular" or not (said.count or said.quantifier or said.collective)


def is_singled_out(sdc: SDC) -> bool:
    """Check that an OBJECT says more than its kind: "the left pallet", "the one by the truck"."""
    if not (sdc.is_leaf or is_complement(sdc)):
        return True
    words = field_words(all_words(sdc))
    if words[-1:] and words[-1] in WORDS["generic"]:  # "your load" isn't "the loaded one"
        words = words[:-1]
    more = concepts(words) or WORDS["telling"].intersection(words) or any(map(is_ordinal, words))
    return bool(more) or names_other(sdc)


def is_there(sdc: SDC) -> bool:
    """Check that a PLACE is one that was spoken of: "there", "on top", "with it"."""
    if sdc.type != "PLACE":
        return False
    if joins(sdc) or sdc.landmark1:
        return joins(sdc) and all(map(is_pronoun, sdc.landmark1))
    words = field_words(all_words(sdc))
    return not {"there", "same"}.isdisjoint(words) or is_on_top(sdc)


def is_on_top(sdc: SDC) -> bool:
    """Check that a PLACE is on something that isn't named: "on top", "aboard"."""
    on = sdc.type == "PLACE" and concepts(field_words(all_words(sdc))) == {"on"}
    return on and not sdc.landmark1


def joins(sdc: SDC) -> bool:
    """Check that a relation leads to where something else goes: "along with", "up there with"."""
    said = set(bare_words(sdc.relation))
    return (
        bool(said & WORDS["accompanying"])
        and said <= WORDS["accompanying"] | WORDS["company"] | WORDS["aboard"]
    )


def is_nounless(leaf: SDC) -> bool:
    """Check that a leaf leaves its noun out: "the empty one", "1", "all three"."""
    words = bare_words(leaf.words)
    if words[-1:] and words[-1] in WORDS["nounless"]:
        return True
    counting = {*COUNTS["counts"], *WORDS["articles"], *WORDS["counting_all"]}
    telling = [word for word in words if word not in WORDS["side_nouns"]]
    return bool(words) and all(word.isdecimal() or word in counting for word in telling)


def names_same(sdc: SDC) -> bool:
    """Check that a leaf names what has been spoken of: "this table"."""
    words = bare_words(sdc.words)
    return len(words) > 1 and words[0] in WORDS["these"]


def names_other(sdc: SDC) -> bool:
    """Check that a leaf names something else than what was meant before: "the other truck".

    So do the rest, "the second one", and "one crate" after another one.
    """
    words = bare_words(sdc.words)
    counted = group(sdc).ordinals if words[-1:] and words[-1] in WORDS["ones"] else ()
    again = words[:1] in (["one"], ["a"], ["an"])
    return not WORDS["rest"].isdisjoint(words) or bool(counted and 1 not in counted) or again


def names_origin(sdc: SDC) -> bool:
    """Check that a leaf names where something was at first: "its old position"."""
    words = set(bare_words(sdc.words))
    return sdc.type == "OBJECT" and bool(
        words & WORDS["former"] and WORDS["areas"].intersection(figure_words(sdc))
    )


def is_stead(sdc: SDC) -> bool:
    """Check that a PLACE is where something else was: "in its place", "in the place of them"."""
    words = bare_words(all_words(sdc))
    owned = WORDS["owners"].intersection(words) or (
        "of" in words and WORDS["it"].intersection(words)
    )
    places = WORDS["stead"].intersection(words)
    return sdc.type in ("PLACE", "PATH") and bool(owned and places) and not names_former(sdc)


def names_former(sdc: SDC) -> bool:
    """Check that words speak of where something was at first: "its old position"."""
    return not WORDS["former"].isdisjoint(bare_words(all_words(sdc)))


def names_held(sdc: SDC) -> bool:
    """Check that an OBJECT names what is on the forks: "what you have", "the one on your fork"."""
    words = bare_words(all_words(sdc))
    robot = WORDS["holder"].intersection(words)
    on_forks = WORDS["forks"].intersection(words) and "on" in words
    beside = concepts(words) & (SIDES | BESIDE)
    holds = on_forks or WORDS["bearing"].intersection(words)
    return sdc.type == "OBJECT" and bool(robot and holds and not beside)


def names_forks(sdc: SDC) -> bool:
    """Check that an OBJECT is the robot's forks."""
    forks = WORDS["forks"].intersection(figure_words(sdc))
    return sdc.type == "OBJECT" and bool(forks) and not names_held(sdc)


def names_lift(sdc: SDC) -> bool:
    """Check that an OBJECT is the robot, or the part of it that lifts: "your forklift"."""
    words = figure_words(sdc)
    return sdc.type == "OBJECT" and bool(words) and words[-1] in WORDS["lifts"]


def named_places(sdc: SDC, names: Iterable[str]) -> frozenset[str]:
    """The places of whose names a clause has most words, if any: "storage" may be A or B.

    >>> from g3.sdc.clauses import Span
    >>> storage = SDC("OBJECT", words=(Span(3, "the"), Span(7, "storage"), Span(15, "area")))
    >>> sorted(named_places(storage, ["receiving", "storage A", "storage B"]))
    ['storage A', 'storage B']
    """
    words = bare_words(all_words(sdc))
    said = set(words[words[:1] in (["a"], ["an"]) :])
    shared = {
        name: sum(
            normalise(word) not in WORDS["areas"] and bool(get_close_matches(word, said, 1, ALIKE))
            for word in name.lower().split()
        )
        for name in names
    }
    most = max(shared.values(), default=0)
    return frozenset(name for name, count in shared.items() if most and count == most)


def names_robot(sdc: SDC) -> bool:
    """Check that a leaf is a word for who is spoken to: "you", "me"."""
    words = bare_words(sdc.words)
    return sdc.type == "OBJECT" and len(words) == 1 and words[0] in WORDS["robot"]


def tells_standing(sdc: SDC) -> bool:
    """Check that an OBJECT says what it stands on: "on the truck", "off the floor"."""
    said = concepts(field_words(sdc.relation))
    return sdc.type == "OBJECT" and bool(sdc.landmark1) and said in ({"on"}, {"from"})


def is_pronoun(sdc: SDC) -> bool:
    """Check that an OBJECT is a pronoun that stands for something spoken of before."""
    words = bare_words(sdc.words)
    return sdc.type == "OBJECT" and len(words) == 1 and words[0] in WORDS["it"]


def side_by_side(before: SDC, sdc: SDC, most: int) -> bool:
    """Check that a clause begins so many characters at most after another one ends."""
    own, following = all_words(before), all_words(sdc)
    return bool(own and following) and 0 <= following[0].start - own[-1].end <= most


def unstressed(words: tuple[str, ...]) -> tuple[str, ...]:
    """Normal forms of words without those that only stress others.

    >>> unstressed(("right", "next", "to"))
    ('next', 'to')
    """
    after = (*words[1:], "")
    return tuple(
        w for w, a in zip(words, after, strict=False) if w != "right" or a not in WORDS["stressed"]
    )


def with_each(sdc: SDC, change: Callable[[SDC], SDC]) -> SDC:
    """A clause with the clauses in it changed."""
    figure, first, second = (
        tuple(map(change, own)) for own in (sdc.figure, sdc.landmark1, sdc.landmark2)
    )
    return replace(sdc, figure=figure, landmark1=first, landmark2=second)


def verb_words(sdc: SDC) -> list[str]:
    """The words of a clause's relation, bare."""
    return bare_words(sdc.relation)


def whole_words(words: Sequence[Span]) -> tuple[Span, ...]:
    """Words whose parts were taken for words, as they are written: "U-turn"."""
    found: list[Span] = []
    for word in words:
        if found and found[-1].end == word.start:
            word = Span(found[-1].start, found.pop().text + word.text)  # noqa: PLW2901
        found.append(word)
    return tuple(found)


def arguments_of(sdc: SDC) -> tuple[SDC, ...]:
    """The arguments of a clause, without implicit ones."""
    return tuple(part for part in (*sdc.landmark1, *sdc.landmark2) if not part.is_implicit)


def subject_of(sdc: SDC) -> SDC | None:
    """The subject of a clause; None if it is implicit."""
    return next((part for part in sdc.figure if not part.is_implicit), None)
