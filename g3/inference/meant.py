"""What words rule out for an OBJECT, whatever the model has learned of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from g3.features.batch import FactorBatch
from g3.groundings import FloatArray, PhysicalObject, Place
from g3.inference.phrases import (
    is_bare,
    is_complement,
    names_other,
    names_same,
    names_thing,
    number_scores,
)
from g3.inference.places import carrier
from g3.inference.salience import alone_scores, is_alone, near_scores, side_told_scores
from g3.inference.sides import MISPLACED, side_scores
from g3.inference.surroundings import Group, Surroundings
from g3.inference.tree import Tree
from g3.language.concepts import concepts
from g3.language.words import field_words
from g3.sdc import SDC, all_words

UNLIKELY = float(np.log(0.01))
"""What it costs that "the other truck" is one that was meant before, or a pallet a place."""
SIDES = frozenset({"left", "right", "front", "back"})


def barred(sdc: SDC, about: Surroundings) -> Callable[[Group], float]:
    """What it costs a leaf to be grounded in what it surely isn't.

    What is carried is no landmark of where it goes. "The other truck" is none that was meant
    before, nor what the load stands on, and "this truck" is one that was. What is no area by its
    noun is no nameless place.
    """
    thing = names_thing(sdc)
    load = {about.load} if about.load else set()
    same = about.spoken - load if names_same(sdc) else frozenset()
    meant = about.spoken | _carrier(about) if names_other(sdc) else set()

    def score(group: Group) -> float:
        if thing and any(isinstance(g, Place) and not g.name for g in group):
            return UNLIKELY
        ids = {g.id for g in group if isinstance(g, PhysicalObject)}
        if same and not ids <= same:
            return UNLIKELY
        return (MISPLACED if ids & load else 0.0) + (UNLIKELY if ids & meant else 0.0)

    return score


def _carrier(about: Surroundings) -> set[str]:
    """Id of what the load stands on."""
    under = carrier(about.state, about.load) if about.load else None
    return {under.id} if under else set()


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
        total = total + side_scores(batch)
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
    if is_alone(sdc):
        total = total + alone_scores(batch, load)
    if (
        about.told_side
        and node not in tree.parts
        and not SIDES & concepts(field_words(all_words(sdc)))
    ):
        total = total + side_told_scores(batch, about.told_side)
    return total
