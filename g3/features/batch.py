"""What features see: a batch of factors, each with one candidate grounding per argument."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Literal

import numpy as np
import numpy.typing as npt

from g3.features.bodies import Bodies, IntArray
from g3.groundings import FloatArray

Role = Literal["figure", "landmark", "theme", "goal"]
"""What a grounding is to its factor.

``figure``: the thing, place or trajectory that the clause denotes. ``landmark``: what it
is related to (OBJECT, PLACE and PATH clauses). ``theme``: the object that an EVENT acts
on. ``goal``: where the EVENT leads, the grounding of its PLACE or of its PATH's landmark.
"""

WordField = Literal["figure", "name", "relation", "goal", "landmark"]
"""Whose words: the figure's, those same words as they are written ("name"), the relation's, those
of the relation of the PATH or PLACE in an EVENT, or those of the landmarks (which the paper's
factors don't see)."""

FieldWords = dict[WordField, tuple[str, ...]]


@dataclass(frozen=True, slots=True)
class Boxes:
    """n upright prisms: corners (n, k, 2), z_min (n,), z_max (n,), in metres."""

    corners: FloatArray
    z_min: FloatArray
    z_max: FloatArray


@dataclass(frozen=True, slots=True)
class FactorBatch:
    """n factor candidates.

    Parameters
    ----------
    bodies
        The groundings that the rows refer to.
    type
        Index into :data:`g3.sdc.SDC_TYPES`, shape (n,).
    figure, landmark, theme, goal
        Which body plays the role, -1 where none does, shape (n,).
    agent
        Start pose x, y, yaw of the agent in the row's context, shape (n, 3).
    agent_end_yaw, agent_mean_yaw
        The agent's heading at the end of the context's log and on average, shape (n,).
    agent_body
        The agent of the row's context, shape (n,).
    peers
        Bodies of the context's objects other than the agent, padded with -1,
        shape (n, p).
    factor
        Which of the word entries a row has, shape (n,).
    words
        The words of each factor's fields.
    """

    bodies: Bodies
    type: npt.NDArray[np.int8]
    figure: IntArray
    landmark: IntArray
    theme: IntArray
    goal: IntArray
    agent: FloatArray
    agent_end_yaw: FloatArray
    agent_mean_yaw: FloatArray
    agent_body: IntArray
    peers: IntArray
    factor: IntArray
    words: Sequence[FieldWords]

    def __len__(self) -> int:
        return len(self.type)

    def role(self, role: Role) -> IntArray:
        """Bodies that play a role, shape (n,)."""
        index: IntArray = getattr(self, role)
        return index

    def take(self, rows: IntArray) -> FactorBatch:
        """The batch of some of the rows, with the words of their factors only."""
        factors, factor = np.unique(self.factor[rows], return_inverse=True)
        rest = {"bodies", "words", "factor"}
        return FactorBatch(
            bodies=self.bodies,
            words=[self.words[i] for i in factors],
            factor=factor.reshape(-1),
            **{f.name: getattr(self, f.name)[rows] for f in fields(self) if f.name not in rest},
        )

    def boxes(self, role: Role) -> Boxes:
        """Prisms of the bodies in a role, at their first pose."""
        return boxes(self.bodies, self.role(role))


def boxes(bodies: Bodies, index: IntArray) -> Boxes:
    """Prisms of some bodies at their first pose."""
    return Boxes(bodies.corners[index], bodies.z_min[index], bodies.z_max[index])
