"""What words rule out for an OBJECT, whatever the model has learned of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import replace

import numpy as np

from g3.features.batch import FactorBatch
from g3.groundings import FloatArray, PhysicalObject, Place
from g3.inference.phrases import (
    is_bare,
    is_complement,
    named_places,
    names_other,
    names_robot,
    names_same,
    names_thing,
    number_scores,
)
from g3.inference.salience import (
    alone_scores,
    is_alone,
    near_scores,
    side_told_scores,
    superlative_scores,
)
from g3.inference.sides import MISPLACED, counted_scores, side_scores
from g3.inference.surroundings import Group, Surroundings
from g3.inference.tree import Tree
from g3.language.concepts import concepts
from g3.language.groups import group as group_of
from g3.language.lexicon import EMPTY, LADEN, PARTS, ROWS, SIDES
from g3.language.words import bare, field_words
from g3.sdc import SDC, all_words

UNLIKELY = float(np.log(0.01))
"""What it costs that "the other truck" is one that was meant before, or a pallet a place."""


def barred(sdc: SDC, about: Surroundings) -> Callable[[Group], float]:
    """What it costs a leaf to be grounded in what it surely isn't.

    What is carried is no landmark of where it goes. "The other truck" is none that was meant
    before, nor what the load stands on, and "this truck" is one that was. Who has a place's name
    means that place; else a noun that names no area is no place. "You" is the robot, "the row" is
    all of a row, nothing stands on "the empty truck", and something does on "the loaded truck".
    """
    thing = names_thing(sdc)
    called = named_places(sdc, (p.name for p in about.state.context.places))
    robot = {about.state.context.agent_id} if names_robot(sdc) else set()
    wrong = _wrongly_laden(sdc, about)
    row = group_of(sdc).collective in ROWS and bool(about.rows)
    load = {about.load} if about.load else set()
    same = about.spoken - load if names_same(sdc) else frozenset()
    meant = about.spoken | {about.carriers.get(i) for i in load} if names_other(sdc) else set()

    def score(group: Group) -> float:
        places = [g for g in group if isinstance(g, Place)]
        if called:
            return 0.0 if any(place.name in called for place in places) else UNLIKELY
        ids = {g.id for g in group if isinstance(g, PhysicalObject)}
        if row and frozenset(ids) not in about.rows:
            return UNLIKELY
        not_same = bool(same) and not ids <= same
        not_robot = bool(robot) and ids != robot
        if (thing and places) or not_same or not_robot or ids & wrong:
            return UNLIKELY
        return (MISPLACED if ids & load else 0.0) + (UNLIKELY if ids & meant else 0.0)

    return score


def _wrongly_laden(sdc: SDC, about: Surroundings) -> AbstractSet[str]:
    """Ids of what isn't empty, or isn't loaded, where a leaf's words say so."""
    words = {bare(word.text) for word in sdc.words}
    if words & PARTS or not words & (EMPTY | LADEN):
        return set()
    laden = set(about.carriers.values())
    return laden if words & EMPTY else about.surfaces - laden


def on_scores(sdc: SDC, batch: FactorBatch, about: Surroundings) -> FloatArray:
    """What it costs each row's figure not to stand on what an OBJECT is on: "the one on the truck".

    Parameters
    ----------
    batch
        Whose first bodies are the context's objects.
    """
    told = concepts(field_words(sdc.relation))
    if "on" not in told or told & (SIDES | {"between"}):
        return np.zeros(len(batch))
    ids = [o.id for o in about.state.context.objects]
    under, surface = np.full((2, len(batch.bodies.z_min)), -1)
    for i, own in enumerate(ids):
        under[i] = ids.index(about.carriers[own]) if own in about.carriers else -1
        surface[i] = own in about.surfaces
    wrong = (batch.landmark >= 0) & (surface[batch.landmark] == 1)
    wrong &= (under[batch.figure] != batch.landmark) & (batch.figure != batch.landmark)
    return np.where(wrong & (batch.bodies.count[batch.figure] == 1), UNLIKELY, 0.0)


def unmeant_scores(tree: Tree, node: int, batch: FactorBatch, sizes: Sequence[int]) -> FloatArray:
    """What it costs rows that an OBJECT's words speak of another number or another thing alike.

    Parameters
    ----------
    sizes
        How many things each row's figure is.
    """
    sdc = tree.nodes[node]
    total = np.zeros(len(batch))
    if not sdc.figure:
        total = total + number_scores(sdc, np.array(sizes))
    if node not in tree.parts:
        if sdc.landmark1 and not is_complement(sdc):
            batch = replace(batch, words=[{**words, "figure": ()} for words in batch.words])
        total = total + side_scores(batch) + counted_scores(batch)
    return total


def salience_scores(tree: Tree, node: int, batch: FactorBatch, about: Surroundings) -> FloatArray:
    """What it costs rows that another thing alike is nearer to what a clause is about.

    Or that another one stands more alone where the words say so, or is on the side that the robot
    has been told to go to.
    """
    sdc = tree.nodes[node]
    total = np.zeros(len(batch))
    load = None
    if about.load:
        load = [o.id for o in about.state.context.objects].index(about.load)
        if is_bare(sdc) and node not in tree.parts:
            total = total + near_scores(batch, load)
    if sdc.type != "OBJECT":
        return total
    total = total + superlative_scores(batch)
    if is_alone(sdc):
        total = total + alone_scores(batch, load)
    if (
        about.told_side
        and node not in tree.parts
        and not SIDES & concepts(field_words(all_words(sdc)))
    ):
        total = total + side_told_scores(batch, about.told_side)
    return total
