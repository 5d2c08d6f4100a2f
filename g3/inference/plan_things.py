"""Things and named places that a text names, and those that have a part in a plan."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from g3.actions.grounding_candidates import carrier
from g3.actions.robot_state import State, is_load
from g3.geometry.footprints import centre, covers
from g3.groundings import FloatArray, Path, Place
from g3.language.lexicon.field_words import normalise
from g3.language.lexicon.tables import WORDS
from g3.language.lexicon.verb_classes import word_class
from g3.language.similarity.presence import best_naming

if TYPE_CHECKING:
    from g3.actions.action_kinds import Action

NAMES, ALIKE = 0.6, 0.03
"""A word names things that it is so likely for, and what is as likely but for so much."""
NEAR_M, NEAR_LARGE_M = 5.0, 7.0
"""Largest distances from the middle of a load or of the robot to things about it: loads, and
larger things; in metres."""


class PlanEnd(NamedTuple):
    """A plan, and what it leads to."""

    actions: Sequence[Action]
    state: State

    @property
    def handled(self) -> list[str]:
        """Ids of the loads that are picked up, carried or put down, each once."""
        return list(dict.fromkeys(a.object_id for a in self.actions if a.object_id))

    @property
    def put(self) -> str | None:
        """Id of the load that was handled last, if it isn't on the forks in the end."""
        handled = [a.object_id for a in self.actions if a.object_id]
        return handled[-1] if handled and self.state.held is None else None


def named_things(words: Sequence[str], state: State) -> list[tuple[str, frozenset[str]]]:
    """Return nouns with the things (by id) and named places that each names as well as any.

    Words that name nothing are left out, and so is the robot.

    Parameters
    ----------
    words
        Words of a text.
    state
        The state in which it was given.
    """
    labels = {
        o.id: tuple(o.labels) for o in state.context.objects if o.id != state.context.agent_id
    } | {place.name: tuple(place.name.split()) for place in state.context.places if place.name}
    found = []
    for word in words:
        likely = {name: naming(word, own) for name, own in labels.items()}
        best = max(likely.values(), default=0.0)
        if best >= NAMES:
            alike = (n for n, likeness in likely.items() if likeness >= best - ALIKE)
            found.append((word, frozenset(alike)))
    return found


def left_aside(
    plan: PlanEnd, named: Sequence[tuple[str, frozenset[str]]], start: State
) -> tuple[str, ...]:
    """Return the words that name things of which none has a part in a plan, each once.

    Parameters
    ----------
    plan
        The plan.
    named
        Nouns with the things that they name (:func:`named_things`).
    start
        The state in which they were said.
    """
    own = about(plan, start)
    return tuple(dict.fromkeys(word for word, things in named if own.isdisjoint(things)))


def about(plan: PlanEnd, start: State) -> set[str]:
    """Return ids and places of what is handled, near where that begins and ends, or driven to.

    Parameters
    ----------
    plan
        The plan.
    start
        The state in which its command was given.
    """
    begins, ends = _where_it_begins(plan, start), where_it_ends(plan)
    return {*plan.handled, *begins, *ends, *_led_by(plan)}


def where_it_ends(plan: PlanEnd) -> set[str]:
    """Return the ids of what is near where a load is put, of what it is put on, and its place.

    Without loads, of what is near the robot; none where a load is lifted.

    Parameters
    ----------
    plan
        The plan.
    """
    state = plan.state
    if plan.put:
        under = carrier(state, plan.put)
        near = _near(state, centre(state.thing(plan.put).prism), {plan.put})
        return near if under is None else near | {under.id}
    return set() if plan.handled else _near(state, state.pose[:2], {state.held})


def _where_it_begins(plan: PlanEnd, start: State) -> set[str]:
    """Return the ids of what is near the loads that are handled, and of what they stand on."""
    found: set[str] = set()
    for load in plan.handled:
        if load != start.held:
            under = carrier(start, load)
            found |= _near(start, centre(start.thing(load).prism), {load})
            found |= {under.id} if under else set()
    return found


def _led_by(plan: PlanEnd) -> set[str]:
    """Return the ids of what the robot drives to, away from or past, wherever it ends."""
    targets = [grounding for action in plan.actions for grounding in action.target]
    return {g.name if isinstance(g, Place) else g.id for g in targets if not isinstance(g, Path)}


def _near(state: State, spot: FloatArray, but: Collection[str | None]) -> set[str]:
    there = {place.name for place in state.context.places if covers(place.prism, spot)}
    return there | {
        o.id
        for o in state.context.objects
        if o.id not in but
        and o.id != state.context.agent_id
        and np.linalg.norm(centre(o.prism) - spot)
        < (NEAR_M if is_load(state, o.id) else NEAR_LARGE_M)
    }


@lru_cache(maxsize=65536)
def naming(word: str, labels: tuple[str, ...]) -> float:
    """Return how well a word names a thing by its labels, from 0 to 1; 0 if it names nothing."""
    return best_naming(word, [labels]) if _may_name(word) else 0.0


@lru_cache(maxsize=65536)
def _may_name(word: str) -> bool:
    """Check that a word may be a noun: it doesn't say how, where or what to do."""
    others = (
        WORDS["place_prepositions"],
        WORDS["articles"],
        WORDS["pronouns"],
        WORDS["quantifiers"],
        WORDS["existential"],
        WORDS["subject_links"],
        WORDS["stating"],
    )
    is_function_word = any(word in known for known in others)
    return not (
        is_function_word or word_class(word) or normalise(word) in WORDS["generic"] or len(word) < 3
    )
