"""Places in line with a row of things: next to one of them, or at the row's end."""

from __future__ import annotations

from math import log

import numpy as np

from g3.actions.arrangements import rows, turned
from g3.features.factor_batch import FactorBatch, Role
from g3.features.sets.named import named, says
from g3.features.sets.ranks import local_centres
from g3.geometry.plane import BoolArray, cross
from g3.inference.potentials.cases import CandidateCase, FactorCase
from g3.inference.potentials.potential_registry import Measured, potential
from g3.inference.problem.clause_roles import landmark_nodes
from g3.language.lexicon.concepts import CONCEPTS
from g3.language.lexicon.field_words import field_words
from g3.language.lexicon.tables import WORDS
from g3.sdc.clauses import SDCType

_PHRASES: tuple[SDCType, ...] = ("OBJECT", "PLACE", "PATH")
_BOTH: tuple[Role, ...] = ("figure", "landmark")
OFF_LINE_M = 1.5
WIDE = 0.2
"""How far from the line between two things is between them, as a share of its length."""


@potential("next-in-row", kind="factor", types=("PLACE",), roles=_BOTH, weight=log(0.1))
def next_in_row(case: FactorCase) -> Measured:
    """A place next to a thing of a row is in line with the row."""
    batch = case.batch
    bodies, mark = batch.bodies, batch.landmark
    applies = (
        says(batch, WORDS["lateral"]) & ~_sided(batch) & (mark >= 0) & (mark != batch.agent_body)
    )
    applies &= bodies.count[mark] == 1
    if not applies.any():
        return False
    middle, peers = local_centres(batch, mark), local_centres(batch, batch.peers)
    alike = (bodies.labels[batch.peers] == bodies.labels[mark][:, None]).all(axis=2)
    alike &= batch.peers != mark[:, None]
    points = np.concatenate((middle[:, None], peers), axis=1)
    across, straight = rows(points, np.column_stack((np.ones(len(batch), dtype=bool), alike)))
    off = turned(local_centres(batch, batch.figure) - middle, across)
    aside: BoolArray = np.abs(off[:, 0]) > np.abs(off[:, 1])
    wrong: BoolArray = applies & straight & aside
    return wrong


@potential("row-line", kind="factor", types=("PLACE",), roles=_BOTH, weight=log(0.1))
def row_line(case: FactorCase) -> Measured:
    """A place at the end or the side of several things is in line with them."""
    batch = case.batch
    bodies, mark = batch.bodies, batch.landmark
    applies = (says(batch, WORDS["ends"]) | _sided(batch)) & (mark >= 0) & (bodies.count[mark] > 1)
    if not applies.any():
        return False
    members = bodies.members[mark]
    known = ~np.isnan(members).any(axis=-1, keepdims=True)
    middle = np.where(known, members, 0.0).sum(axis=1) / np.maximum(known.sum(axis=1), 1)
    offset = np.where(known, members - middle[:, None], 0.0)
    along = np.linalg.eigh(np.swapaxes(offset, 1, 2) @ offset)[1][..., 1]
    aside = np.abs(cross(bodies.centre[batch.figure] - middle, along)) > OFF_LINE_M
    result: BoolArray = applies & aside
    return result


@potential("place-between", kind="factor", types=("PLACE",), roles=_BOTH, weight=log(0.01))
def place_between(case: FactorCase) -> Measured:
    """A place between things is on the way from one to another, rather in the middle of it."""
    batch = case.batch
    bodies, mark = batch.bodies, batch.landmark
    applies = says(batch, WORDS["between"]) & (mark >= 0) & (mark != batch.agent_body)
    if not applies.any():
        return False
    members = bodies.members[mark]
    one, other = np.triu_indices(members.shape[1], 1)
    way = members[:, other] - members[:, one]
    length = np.maximum(np.linalg.norm(way, axis=-1), 1e-9)
    off = bodies.centre[batch.figure][:, None] - members[:, one]
    along = (off * way).sum(axis=-1) / length**2
    aside = np.abs(cross(off, way)) / length
    among = (along > 0) & (along < 1) & (aside <= np.maximum(OFF_LINE_M, WIDE * length))
    off_middle = np.where(among, np.abs(2 * along - 1), 1.0).min(axis=1)
    return np.where(applies, off_middle, 0.0)


@potential(
    "between-several", kind="argument", types=_PHRASES, roles=("landmark",), weight=log(0.001)
)
def between_several(case: CandidateCase) -> Measured:
    """Nothing is between one thing."""
    said = WORDS["between"].intersection(field_words(case.clause.relation))
    if not said or len(landmark_nodes(case.tree, case.within)) != 1:
        return False
    return case.each(lambda group: len(group) == 1)


def _sided(batch: FactorBatch) -> BoolArray:
    lateral = [CONCEPTS.index("left"), CONCEPTS.index("right")]
    sided: BoolArray = np.logical_or(*named(batch, ("relation",))[:, lateral].T)
    return sided
