"""Objects that an OBJECT's words allow: those that fit its noun and its modifiers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from eval.judging.grounded_command import GroundedCommand, Things
from eval.judging.layout import (
    BESIDE_M,
    NEAR_M,
    by_distance,
    in_order,
    inner,
    is_between,
    nearest,
    of_kind,
    prisms,
    straight_ahead,
)
from eval.judging.modifiers import Modifier, is_reflexive, modifiers_of
from g3.actions.grounding_candidates import carrier
from g3.inference.problem.phrases import is_area, is_pronoun
from g3.language.lexicon.concepts import Concept
from g3.language.lexicon.word_sets import EMPTY
from g3.sdc.clauses import Span


def allowed(words: GroundedCommand, node: int, also: tuple[Span, ...] = ()) -> Things:
    """Return the ids of objects that an OBJECT's words allow; none if it isn't grounded.

    A modifier that can't be measured allows only the annotated thing. In the annotated world this
    thing is always allowed.

    `also` are words elsewhere that modify the OBJECT: "from the right".
    """
    own = words.things[node]
    if not words.annotated[node] or words.robot in own or is_pronoun(words.tree.nodes[node]):
        return own
    found, known = words.alike(node), True
    for modifier in modifiers_of(words, node, also):
        case = _Case(words, node, modifier, found)
        fitting = next((fit(case) for applies, fit in _RULES if applies(case)), None)
        known &= fitting is not None
        found = found if fitting is None else fitting
    if words.own:
        return own | found if known else own
    return found if known else found & own


@dataclass(frozen=True)
class _Case:
    """A modifier, and the things that the words before it allow."""

    words: GroundedCommand
    node: int
    modifier: Modifier
    found: Things

    @cached_property
    def objects(self) -> list[int]:
        nodes = self.words.tree.nodes
        return [n for n in self.modifier.landmarks if nodes[n].type == "OBJECT" and n != self.node]

    @cached_property
    def landmarks(self) -> Things:
        return frozenset(i for n in self.objects for i in allowed(self.words, n))

    @property
    def of_robot(self) -> bool:
        return not self.landmarks or self.landmarks == {self.words.robot}

    def names(self, *concepts: Concept) -> bool:
        return bool(self.modifier.concepts & set(concepts))

    @property
    def missing(self) -> bool:
        """True if a landmark isn't in this world."""
        return any(self.words.labels[n] and not self.words.things[n] for n in self.objects)

    @property
    def unclear(self) -> bool:
        """True if the modifier excludes a position, or describes an action on the object."""
        return self.modifier.negative or len(self.objects) < len(self.modifier.landmarks)

    @property
    def ungrounded(self) -> bool:
        return bool(self.objects) and not self.landmarks and not self.names("between")

    @property
    def says_where(self) -> bool:
        return self.modifier.negative or bool(self.modifier.concepts)


def _ordered(case: _Case) -> Things:
    group = case.landmarks - {case.words.robot}
    return in_order(case.words, case.modifier, case.found, group)


def _on_floor(case: _Case) -> Things:
    return frozenset(i for i in case.found if carrier(case.words.state, i) is None)


def _empty(case: _Case) -> Things:
    state = case.words.state
    laden = {under.id for o in state.context.objects if (under := carrier(state, o.id))}
    return case.found - laden


def _alone(case: _Case) -> Things:
    """Return the object furthest from all others."""
    peers = of_kind(case.words, case.found)
    gaps = {
        i: nearest(case.words.state.thing(i).prism, prisms(case.words, peers - {i}))
        for i in case.found
    }
    return frozenset(i for i in case.found if gaps[i] == max(gaps.values()))


def _between(case: _Case) -> Things:
    """Return the objects between landmarks; without any, those inside a row."""
    if not case.landmarks:
        return inner(case.words, case.found)
    ends = prisms(case.words, case.landmarks)
    state = case.words.state
    return frozenset(i for i in case.found if is_between(state.thing(i).prism, ends))


def _on(case: _Case) -> Things:
    state = case.words.state
    if case.words.robot in case.landmarks:
        return case.found & {state.held or ""}
    under = {i: carrier(state, i) for i in case.found}
    return frozenset(i for i, what in under.items() if what and what.id in case.landmarks)


def _beside(case: _Case) -> Things:
    around = prisms(case.words, case.landmarks)
    reach = BESIDE_M if case.names("near") else NEAR_M
    state = case.words.state
    others = case.found - case.landmarks
    return frozenset(i for i in others if nearest(state.thing(i).prism, around) <= reach)


def _on_area(case: _Case) -> bool:
    nodes = case.words.tree.nodes
    return case.names("on") and any(is_area(nodes[n]) for n in case.objects)


def _by_itself(case: _Case) -> bool:
    return any(is_reflexive(case.words.tree.nodes[n]) for n in case.objects)


_RULES: tuple[tuple[Callable[[_Case], bool], Callable[[_Case], Things | None]], ...] = (
    (lambda c: c.unclear and c.says_where, lambda _: None),
    (lambda c: c.unclear, lambda c: c.found),
    (lambda c: c.missing, lambda _: frozenset()),
    (lambda c: bool(c.modifier.side or c.modifier.ordinal), _ordered),
    (_on_area, _on_floor),
    (lambda c: bool(EMPTY.intersection(c.modifier.words)), _empty),
    (_by_itself, _alone),
    (lambda c: c.ungrounded and c.says_where, lambda _: None),
    (lambda c: c.ungrounded, lambda c: c.found),
    (lambda c: c.names("between"), _between),
    (lambda c: c.names("back") and c.of_robot, lambda c: straight_ahead(c.words, c.found, -1)),
    (lambda c: c.names("front") and c.of_robot, lambda c: straight_ahead(c.words, c.found)),
    (lambda c: c.names("on") and bool(c.landmarks), _on),
    (lambda c: c.names("near", "front", "back") and bool(c.landmarks), _beside),
    (lambda c: c.names("far"), lambda c: by_distance(c.words, c.found, far=True)),
    (lambda c: c.names("near"), lambda c: by_distance(c.words, c.found, far=False)),
    # What is said of the robot and of no side is most often what stands before it.
    (lambda c: c.of_robot and bool(c.landmarks), lambda c: straight_ahead(c.words, c.found)),
    (lambda c: not c.landmarks, lambda c: c.found),
)
"""Conditions on a modifier, each with the objects that fit. The first that applies counts."""
