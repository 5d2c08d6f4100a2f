"""Names of things in a world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from g3.actions.robot_state import State, is_load, names_person
from g3.language.lexicon.field_words import bare, normalise
from g3.language.similarity.presence import best_naming, is_called
from g3.sdc.clauses import Span
from g3.short_repr import short_repr

LIKELY = 0.6
"""A word that is so like a label of a load may name it."""


@short_repr
@dataclass(frozen=True)
class Nouns:
    """Names of things in a world.

    Parameters
    ----------
    state
        The world.
    """

    state: State

    @cached_property
    def _labels(self) -> dict[str, frozenset[str]]:
        """Normal forms of the labels of each thing, by id."""
        return {o.id: frozenset(map(normalise, o.labels)) for o in self.state.context.objects}

    @cached_property
    def loads(self) -> frozenset[str]:
        """Normal forms of the labels of what the forks can lift."""
        names = (name for name in self._labels if is_load(self.state, name))
        return frozenset(label for name in names for label in self._labels[name])

    @cached_property
    def others(self) -> frozenset[str]:
        """Normal forms of the labels that no load has."""
        return frozenset().union(*self._labels.values()) - self.loads

    @cached_property
    def people(self) -> frozenset[str]:
        """Ids of the people that are to be seen."""
        return frozenset(o.id for o in self.state.context.objects if names_person(o.labels))

    def name_load(self, words: Sequence[Span]) -> bool:
        """Check that words name a load: by a label, by its form, or by a word like one."""
        said = list(filter(None, (bare(word.text) for word in words)))
        if not self.loads.isdisjoint(map(normalise, said)):
            return True
        likely = bool(said) and self._likeness(said[-1], of_loads=True) >= LIKELY
        return likely and not self.call_robot(words)

    def name_other(self, words: Sequence[Span]) -> bool:
        """Check that words name neither a load nor the robot, by a label or by a word like one."""
        said = list(filter(None, (bare(word.text) for word in words)))
        if not said or self.call_robot(words):
            return False
        if not self.others.isdisjoint(map(normalise, said)):
            return True
        likeness = self._likeness(said[-1], of_loads=False)
        if likeness < LIKELY or not self.loads.isdisjoint(map(normalise, said)):
            return False
        return likeness > self._likeness(said[-1], of_loads=True)

    def _likeness(self, noun: str, *, of_loads: bool) -> float:
        things = self.state.context.objects
        known = (o.labels for o in things if is_load(self.state, o.id) == of_loads)
        return best_naming(noun, known)

    def call_robot(self, words: Sequence[Span]) -> bool:
        """Check that words are a name of the robot: "forklift"."""
        robot = self.state.context.agent.labels
        return bool(words) and all(is_called(bare(word.text), robot) for word in words)
