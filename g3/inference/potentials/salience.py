"""Salience among things alike where words say no more than their kind.

"Next to the pallet" is at the one that is nearest to what goes there, "the lonely one" is furthest
from its like, and who swings left comes to the one on the left.
"""

from __future__ import annotations

from collections.abc import Callable
from math import log

import numpy as np

from g3.features.sets.named import says
from g3.features.sets.order import rivals
from g3.features.sets.ranks import SAME_PLACE_M, is_robot, local_centres
from g3.geometry.plane import BoolArray
from g3.groundings import FloatArray
from g3.inference.potentials.cases import FactorCase
from g3.inference.potentials.potential_registry import Measured, potential
from g3.inference.problem.phrases import is_bare
from g3.language.discourse.groups import noun_leaf
from g3.language.lexicon.concepts import SIDES, concepts
from g3.language.lexicon.field_words import bare, field_words
from g3.language.lexicon.tables import WORDS
from g3.sdc.clauses import SDC, all_words

FAR_TIMES = 1.5
"""A thing near a landmark is at most so many times as far from it as another one alike."""
OPPOSITE = 0.2
"""What lies on the other side than one that was told has a sine of its direction beyond this."""


def is_alone(sdc: SDC) -> bool:
    """Check that an OBJECT's own words say that it stands alone: "lonely", "by itself"."""
    own = field_words([*noun_leaf(sdc).words, *sdc.relation])
    marks = [bare(word.text) for mark in sdc.landmark1 for word in all_words(mark)]
    return bool(WORDS["alone"].intersection(own)) or bool(WORDS["selves"].intersection(marks))


@potential("alone", kind="factor", types=("OBJECT",), weight=log(0.1))
def alone(case: FactorCase) -> Measured:
    """Nothing alike is further from its like than "the lonely one"."""
    if not is_alone(case.sdc):
        return False
    batch, load = case.batch, case.load
    bodies, peers = batch.bodies, batch.peers
    alike = (bodies.labels[peers] & bodies.labels[batch.figure][:, None]).any(axis=2)
    alike &= (peers != batch.figure[:, None]) & (peers != load)
    body = np.column_stack((batch.figure, peers))
    seen = np.column_stack((batch.figure != load, alike))
    gap = np.linalg.norm(bodies.centre[body][:, :, None] - bodies.centre[body][:, None], axis=-1)
    both = seen[:, :, None] & seen[:, None] & ~np.eye(body.shape[1], dtype=bool)
    nearest = np.where(both, gap, np.inf).min(axis=2)
    nearest[np.isinf(nearest)] = -np.inf
    crowded: BoolArray = seen[:, 0] & (nearest[:, 0] < nearest.max(axis=1) - SAME_PLACE_M)
    return crowded


@potential(
    "superlative",
    kind="factor",
    types=("OBJECT",),
    roles=("figure", "landmark"),
    weight=2 * log(0.05),
)
def superlative(case: FactorCase) -> Measured:
    """Nothing alike is nearer than "the nearest to it", nor farther than "the farthest"."""
    near, far = (says(case.batch, WORDS[name]) for name in ("nearest", "farthest"))
    sign = 1.0 * near - far
    return _beaten(case, sign != 0, lambda own, others: sign[:, None] * (own - others))


@potential("near-to", kind="factor", types=("OBJECT",), roles=("figure", "landmark"), weight=-3.0)
def near_to(case: FactorCase) -> Measured:
    """Nothing alike is by half nearer than "the crate next to the truck"."""
    near = says(case.batch, WORDS["next_to"]) & ~says(case.batch, WORDS["distant"])
    return _beaten(case, near, lambda own, others: own - FAR_TIMES * others)


def _beaten(
    case: FactorCase, said: BoolArray, lead: Callable[[FloatArray, FloatArray], FloatArray]
) -> Measured:
    """Check that a rival fits better by its distance from the landmark than a single figure does.

    Parameters
    ----------
    said
        Of which rows the words compare distances, shape (n,).
    lead
        By how many metres rivals fit better, (n, p), by the figure's distance, (n, 1), and theirs.
    """
    batch, bodies = case.batch, case.batch.bodies
    applies = said & (batch.landmark >= 0) & (batch.landmark != batch.agent_body)
    if not applies.any():
        return False
    mark = bodies.centre[batch.landmark]
    own = np.linalg.norm(bodies.centre[batch.figure] - mark, axis=-1)
    others = np.linalg.norm(bodies.centre[batch.peers] - mark[:, None], axis=-1)
    rival = rivals(batch) & (batch.peers != batch.landmark[:, None])
    beaten = (rival & (lead(own[:, None], others) > SAME_PLACE_M)).any(axis=1)
    result: BoolArray = applies & beaten & (bodies.count[batch.figure] == 1)
    return result


@potential("told-side", kind="factor", types=("OBJECT", "PLACE"), weight=log(0.1))
def told_side(case: FactorCase) -> Measured:
    """After "swing left" the robot comes to nothing on its right."""
    side = case.problem.told_side
    if not side or case.is_part or case.sdc.type != "OBJECT":
        return False
    if SIDES & concepts(field_words(all_words(case.sdc))):
        return False
    own = local_centres(case.batch, case.batch.figure)
    leftward = own[:, 1] / np.maximum(np.linalg.norm(own, axis=1), 1e-9)
    opposite: BoolArray = (leftward if side == "left" else -leftward) < -OPPOSITE
    return opposite & ~is_robot(case.batch)


@potential("near-load", kind="factor", types=("OBJECT",), weight=log(0.1))
def near_load(case: FactorCase) -> Measured:
    """Of things alike the landmark is nearest to what is moved: "next to the pallet"."""
    batch, load = case.batch, case.load
    if load is None or case.is_part or not is_bare(case.sdc):
        return False
    labels = batch.bodies.labels
    alike = (labels[batch.peers] & labels[batch.figure][:, None]).any(axis=2)
    rival = rivals(batch) & alike & (batch.peers != load)
    middle = local_centres(batch, np.full(len(batch), load))
    own = np.linalg.norm(local_centres(batch, batch.figure) - middle, axis=-1)
    others = np.linalg.norm(local_centres(batch, batch.peers) - middle[:, None], axis=-1)
    farther = (rival & (others < own[:, None] - SAME_PLACE_M)).any(axis=1)
    farther &= (batch.bodies.count[batch.figure] == 1) & ~is_robot(batch)
    result: BoolArray = farther
    return result
