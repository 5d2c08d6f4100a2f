"""Antecedents of "it", "them" and "the other one": earlier OBJECTs of the same command.

Clauses are told by their places in breadth-first order (:func:`g3.sdc.clauses.breadth_first`), as
groundings are. The words alone rarely settle what a pronoun stands for; the antecedents found here
are candidates with probabilities, to be resolved together with the groundings. As a factor: call
:func:`anaphors` once with all top-level clauses of a command, and add to the score of a joint
grounding, for each anaphor of the kind ``same``, the logarithm of the sum of the probabilities of
the antecedents that are grounded in the same thing (for ``one`` and ``other``: in a thing of the
same kind, and for ``other`` not the same), with a floor for what the list doesn't have.

>>> from g3.sdc.sdc_notation import parse_brackets
>>> sdcs = parse_brackets("EVENT(r = Lift, l = OBJ(f = the box)); EVENT(r = drop, l = OBJ(f = it))")
>>> [(a.index, a.kind, [x.index for x in a.antecedents]) for a in anaphors(sdcs)]
[(5, 'same', [3])]
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from math import exp
from typing import Literal, NamedTuple

from g3.language.discourse.groups import Group, group, noun_words
from g3.language.discourse.negation import negated
from g3.language.lexicon.field_words import bare_words
from g3.language.lexicon.tables import WORDS
from g3.language.lexicon.verb_chains import verb_of
from g3.sdc.clauses import CHILD_FIELDS, SDC, Field, all_words, breadth_first, child_indices
from g3.short_repr import short_repr

Kind = Literal["same", "one", "other"]
"""``same``: the thing that the antecedent is ("it", "them", "that pallet"). ``one``: a thing of
its kind ("one", "the left one", "the ones"). ``other``: one of its kind, but not it ("the other",
"another pallet", "the rest")."""

_Role = Literal["object", "subject", "landmark", "modifier"]
"""What an OBJECT is in its clause: what an EVENT is done to, who does it, the landmark of a PLACE
or PATH, or the landmark of another OBJECT's modifier."""

_NO_NOUNS = WORDS["pronouns"] | WORDS["ones"] | WORDS["rest"]


@dataclass(frozen=True, slots=True)
class Features:
    """Evidence for and against an antecedent.

    Parameters
    ----------
    clauses
        How many top-level clauses earlier it stands; 0 in the same one.
    first
        Whether it is the first of the candidates in its top-level clause.
    direct_object
        Whether it is what its EVENT is done to.
    same_role
        Whether it has the role in its clause that the anaphor has.
    agrees
        Whether both are singular or both plural.
    same_noun
        Whether both have the same noun ("that crate"); if any antecedent has, the others are
        left out. False for pronouns.
    person
        Whether exactly one of the two is a person: "him" and "the crate".
    in_negated
        Whether it stands in a negated clause: "don't take the crate".
    reached
        Whether the clause before goes there to take it: "go to the crate and lift it".
    """

    clauses: int
    first: bool
    direct_object: bool
    same_role: bool
    agrees: bool
    same_noun: bool
    person: bool
    in_negated: bool
    reached: bool


@short_repr
@dataclass(frozen=True, slots=True)
class Antecedent:
    """An OBJECT that an anaphor can stand for.

    Parameters
    ----------
    index
        Its place in breadth-first order.
    probability
        How probable it is by its features; those of one anaphor add up to 1.
    features
        What speaks for and against it.
    """

    index: int
    probability: float
    features: Features


@short_repr
@dataclass(frozen=True, slots=True)
class Anaphor:
    """An OBJECT whose meaning another one gives.

    Parameters
    ----------
    index
        Its place in breadth-first order.
    kind
        How its thing is related to the antecedent's.
    antecedents
        The candidates, most probable first; empty where none stands before it.
    """

    index: int
    kind: Kind
    antecedents: tuple[Antecedent, ...]


WEIGHTS = {
    "clauses": -0.3,
    "first": 0.7,
    "direct_object": 0.7,
    "same_role": 1.5,
    "agrees": 2.0,
    "same_noun": 1.0,
    "person": -3.0,
    "in_negated": -1.0,
    "reached": 3.0,
}
"""How much each feature speaks for an antecedent: fitted to the groundings of the corpus
``warehouse`` and rounded, but for those that occur too rarely there: `same_noun`, `person` and
`reached`."""


def anaphors(sdcs: Sequence[SDC]) -> tuple[Anaphor, ...]:
    """The OBJECTs of a command that stand for earlier ones, with their candidate antecedents.

    Parameters
    ----------
    sdcs
        The top-level clauses of a command.

    Returns
    -------
    tuple of Anaphor
        In the order of the text.

    Examples
    --------
    >>> from g3.sdc.sdc_notation import parse_brackets
    >>> trees = "EVENT(r = Lift, l = OBJ(f = tires)); EVENT(r = drop, l = OBJ(f = them))"
    >>> sdcs = parse_brackets(trees, command="Lift tires and drop them")
    >>> [(a.index, a.kind, [b.index for b in a.antecedents]) for a in anaphors(sdcs)]
    [(5, 'same', [3])]
    """
    mentions = _mentions(sdcs)
    found = []
    for place, mention in enumerate(mentions):
        kind = anaphor_kind(mention.sdc)
        if kind is not None:
            earlier = [m for m in mentions[:place] if _can_be(m, mention)]
            found.append(Anaphor(mention.index, kind, _ranked(mention, kind, earlier)))
    return tuple(found)


def anaphor_kind(sdc: SDC) -> Kind | None:
    """Return how an OBJECT stands for another one; None if it stands for itself."""
    if sdc.type != "OBJECT":
        return None
    words = noun_words(sdc)
    if not words:
        return None
    if any(word in WORDS["rest"] for word in words):
        return "other"
    if words[-1] in WORDS["ones"] and not _is_partitive(sdc):
        return "one"
    if words[-1] in WORDS["pronouns"] or words[0] in WORDS["demonstratives"]:
        return "same"
    return None


def _is_partitive(sdc: SDC) -> bool:
    """Check that it says itself of what it is one: "one of the pallets"."""
    while sdc.figure:
        if sdc.relation and sdc.relation[0].text.lower() == "of":
            return True
        sdc = sdc.figure[0]
    return False


@dataclass(frozen=True, slots=True, eq=False)
class _Mention:
    """An OBJECT with all its modifiers.

    `hosts` are the places of those that it modifies, from the outermost; `event` is the EVENT that
    it is an argument of, -1 for none, and `verb` has the classes of its verb.
    """

    sdc: SDC
    index: int
    start: int
    number: int
    role: _Role
    hosts: tuple[int, ...]
    event: int
    negated: bool
    group: Group
    verb: frozenset[str]


class _Place(NamedTuple):
    """Place of a clause, as :class:`_Mention` has it.

    `top` is the OBJECT that it is in the figure of, -1 for none.
    """

    number: int
    role: _Role = "object"
    hosts: tuple[int, ...] = ()
    event: int = -1
    negated: bool = False
    top: int = -1
    verb: frozenset[str] = frozenset()


def _mentions(sdcs: Sequence[SDC]) -> list[_Mention]:
    """The OBJECTs that have words, in the order of the text."""
    nodes = list(breadth_first(sdcs))
    children = child_indices(sdcs)
    found = []
    pending = [(number, _Place(number)) for number in range(len(sdcs))]
    while pending:
        index, place = pending.pop()
        sdc = nodes[index]
        words = all_words(sdc)
        if sdc.type == "OBJECT" and place.top < 0 and words and noun_words(sdc):
            number, role, hosts, event, no, _, verb = place
            start, own = words[0].start, group(sdc)
            found.append(_Mention(sdc, index, start, number, role, hosts, event, no, own, verb))
        pending += [
            (child, _inside(sdc, index, place, field))
            for field in CHILD_FIELDS
            for child in children[index].get(field, ())
        ]
    return sorted(found, key=lambda mention: (mention.start, mention.index))


def _inside(sdc: SDC, index: int, place: _Place, field: Field) -> _Place:
    if sdc.type == "OBJECT":
        top = index if place.top < 0 else place.top
        if field == "f":
            return place._replace(top=top)
        return place._replace(role="modifier", hosts=(*place.hosts, top), event=-1, top=-1)
    no = place.negated or negated(sdc)
    if sdc.type == "EVENT":
        role: _Role = "subject" if field == "f" else "object"
        verb = verb_of(tuple(bare_words(sdc.relation))).classes
        return place._replace(role=role, event=index, negated=no, top=-1, verb=verb)
    return place._replace(role="landmark", negated=no, top=-1)


def _can_be(earlier: _Mention, anaphor: _Mention) -> bool:
    """Check that one can be the other's antecedent.

    The robot can't, and arguments of the same clause are one thing only with a reflexive.
    """
    words, ours = noun_words(earlier.sdc), noun_words(anaphor.sdc)
    if words[-1] in WORDS["no_antecedents"] or words[0] in ("your", "my"):
        return False
    is_host = earlier.index in anaphor.hosts[-1:]
    same_event = 0 <= anaphor.event == earlier.event
    if ours[-1] in WORDS["reflexives"]:
        return is_host or same_event or not anaphor.hosts
    together = same_event or (is_host and anaphor.event < 0)
    return not together or anaphor_kind(anaphor.sdc) != "same"


def _ranked(anaphor: _Mention, kind: Kind, earlier: Sequence[_Mention]) -> tuple[Antecedent, ...]:
    firsts = {mention.number: mention.index for mention in reversed(earlier)}
    found = []
    for mention in earlier:
        features = _features(anaphor, mention, first=firsts[mention.number] == mention.index)
        found.append((mention.index, features, exp(_score(features))))
    own_noun = kind == "other" and noun_words(anaphor.sdc)[-1] not in _NO_NOUNS
    if own_noun or any(features.same_noun for _, features, _ in found):
        found = [item for item in found if item[1].same_noun]
    total = sum(odds for _, _, odds in found)
    antecedents = [Antecedent(index, odds / total, features) for index, features, odds in found]
    return tuple(sorted(antecedents, key=lambda antecedent: -antecedent.probability))


def _features(anaphor: _Mention, mention: _Mention, *, first: bool) -> Features:
    ours, theirs = noun_words(anaphor.sdc), noun_words(mention.sdc)
    is_person = ours[-1] in WORDS["personal"]
    return Features(
        clauses=anaphor.number - mention.number,
        first=first,
        direct_object=mention.role == "object",
        same_role=mention.role == anaphor.role,
        agrees=mention.group.number == anaphor.group.number,
        same_noun=ours[-1] not in _NO_NOUNS and _singular(ours[-1]) in map(_singular, theirs),
        person=is_person != (theirs[-1] in WORDS["persons"]),
        in_negated=mention.negated and not anaphor.negated,
        reached=_is_reached(mention, anaphor),
    )


def _is_reached(mention: _Mention, anaphor: _Mention) -> bool:
    goes = mention.verb == {"going"} and mention.role == "landmark"
    takes = anaphor.verb == {"taking"} and anaphor.role == "object"
    return goes and takes and mention.number == anaphor.number - 1


def _singular(noun: str) -> str:
    return noun.removesuffix("s")


def _score(features: Features) -> float:
    values = {field.name: float(getattr(features, field.name)) for field in fields(features)}
    return sum(weight * values[name] for name, weight in WEIGHTS.items())
