"""Referents of pronouns and "there": antecedents, and the last thing handled or come to."""

from __future__ import annotations

from collections.abc import Iterable
from math import log

import numpy as np

from g3.actions.robot_state import names_person
from g3.geometry.plane import BoolArray
from g3.groundings import FloatArray
from g3.inference.potentials.cases import ReferentCase
from g3.inference.potentials.potential_registry import Measured, potential
from g3.inference.problem.grounding_problem import Group, group_key, things_of
from g3.language.lexicon.field_words import bare_words
from g3.language.lexicon.tables import WORDS

LAST, EARLIER = 0.9, 0.1
"""Probability of what was spoken of last, and how much less probable each thing before it is."""
UNSPOKEN = 0.01
"""Probability that a pronoun stands for a thing that was not spoken of."""


def _scores(case: ReferentCase, likely: Iterable[tuple[Group, float]]) -> FloatArray:
    """Log-probabilities of candidates, from those of what is likely."""
    known: dict[tuple[object, ...], float] = {}
    for group, probability in likely:
        known[group_key(group)] = known.get(group_key(group), 0.0) + probability
    masses = [known.get(group_key(group), 0.0) for group in case.groups]
    result: FloatArray = np.log(np.maximum(masses, UNSPOKEN))
    return result


@potential("antecedent", kind="referent", types=("OBJECT",), weight=1.0)
def antecedent(case: ReferentCase) -> Measured:
    """A pronoun stands for one of its antecedents, each as probable as its words make it."""
    known = case.problem.antecedents.get(case.node, ())
    return bool(known) and _scores(case, known)


@potential("last-handled", kind="referent", types=("OBJECT",), weight=1.0)
def last_handled(case: ReferentCase) -> Measured:
    """A pronoun without antecedents stands for what was acted on last, or before that."""
    recent = dict.fromkeys(reversed(case.problem.referents))
    unknown = not case.problem.antecedents.get(case.node)
    return unknown and _scores(case, ((g, LAST * EARLIER**i) for i, g in enumerate(recent)))


@potential("not-itself", kind="referent", types=("OBJECT",), weight=log(0.05))
def not_itself(case: ReferentCase) -> Measured:
    """A load isn't the landmark of its own goal: "put it next to them"."""
    load = case.problem.load
    return bool(load) and np.array([load in {t.id for t in things_of(g)} for g in case.groups])


@potential("person-pronoun", kind="referent", types=("OBJECT",), weight=2 * log(0.01))
def person_pronoun(case: ReferentCase) -> Measured:
    """A personal pronoun stands for a person, and no other one does: "bring it to him"."""
    words = bare_words(case.tree.nodes[case.node].words)
    if not words:
        return False
    wanted = not WORDS["personal"].isdisjoint(words)
    people = np.array([_are_people(g) for g in case.groups], dtype=bool)
    result: BoolArray = people != wanted
    return result


def _are_people(group: Group) -> bool:
    things = things_of(group)
    return bool(things) and all(names_person(thing.labels) for thing in things)


@potential("last-goal", kind="referent", types=("PLACE",), weight=1.0)
def last_goal(case: ReferentCase) -> FloatArray:
    """A place that was spoken of is where the last clause led, or the one before: "there"."""
    result: FloatArray = log(LAST) + log(EARLIER) * np.arange(len(case.groups), dtype=float)
    return result
