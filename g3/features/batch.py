"""What features see: a batch of factors, each with one candidate grounding per argument."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, Literal, TypeVar

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

T = TypeVar("T")

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
    known
        What was computed of the batch for one feature set and serves others too.
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
    known: dict[Hashable, Any] = field(init=False, default_factory=dict, compare=False, repr=False)

    def __len__(self) -> int:
        return len(self.type)

    def role(self, role: Role) -> IntArray:
        """Bodies that play a role, shape (n,)."""
        index: IntArray = getattr(self, role)
        return index

    def take(self, rows: IntArray) -> FactorBatch:
        """The batch of some of the rows, with the words of their factors only."""
        factors, factor = np.unique(self.factor[rows], return_inverse=True)
        return FactorBatch(
            bodies=self.bodies,
            words=[self.words[i] for i in factors],
            factor=factor.reshape(-1),
            **{name: _rows(getattr(self, name), rows) for name in _GEOMETRY},
        )

    def once(self, name: Hashable, compute: Callable[[FactorBatch], T]) -> T:
        """What a function gives for the batch, computed the first time that it's asked for.

        Several feature sets share it, so nobody may change it.
        """
        if name not in self.known:
            self.known[name] = compute(self)
        result: T = self.known[name]
        return result

    def shared(self, compute: Callable[[FactorBatch], FloatArray]) -> FloatArray:
        """Values (n, ...) of a function that sees no words, computed once for equal rows.

        As with :meth:`once`, nobody may change them.
        """
        return self.once(compute, lambda batch: batch._expanded(compute))

    def _expanded(self, compute: Callable[[FactorBatch], FloatArray]) -> FloatArray:
        found = self.once("different", _different)
        if found is None:
            return compute(self)
        different, row = found
        return different.once(compute, compute)[row]

    def boxes(self, role: Role) -> Boxes:
        """Prisms of the bodies in a role, at their first pose."""
        return boxes(self.bodies, self.role(role))


_GEOMETRY = tuple(
    f.name for f in fields(FactorBatch) if f.name not in ("bodies", "factor", "words", "known")
)
"""All that says where things are, a value or a row of them for each row of the batch."""


def _rows(values: npt.NDArray[Any], rows: IntArray) -> npt.NDArray[Any]:
    if values.strides[0] == 0 and len(values):
        return np.broadcast_to(values[0], (len(rows), *values.shape[1:]))
    return values[rows]


def _different(batch: FactorBatch) -> tuple[FactorBatch, IntArray] | None:
    """The rows that differ in anything but words, and which of them each row is.

    None where all rows differ.
    """
    values = [getattr(batch, name) for name in _GEOMETRY]
    differing = [v.reshape(len(batch), -1) for v in values if v.strides[0] != 0]
    columns = [np.ascontiguousarray(c) for v in differing for c in v.T]
    first, row = _equal_rows(columns, len(batch))
    if len(first) == len(batch):
        return None
    taken = {name: _rows(getattr(batch, name), first) for name in _GEOMETRY}
    none = np.zeros(len(first), dtype=np.intp)
    return FactorBatch(batch.bodies, factor=none, words=({},), **taken), row


def _equal_rows(columns: Sequence[npt.NDArray[Any]], n: int) -> tuple[IntArray, IntArray]:
    """Where each different row of a table comes first, and which of those each row is."""
    code = np.zeros(n, dtype=np.uint64)
    bits = [c.view(np.uint64) if c.itemsize == 8 else c.astype(np.uint64) for c in columns]
    for column in bits:
        code = (code ^ column) * _ODD
        code ^= code >> _SHIFT
    _, first, row = np.unique(code, return_index=True, return_inverse=True)
    row = row.reshape(-1)
    if all(np.array_equal(column, column[first][row]) for column in bits):
        return first, row
    everything = np.arange(n)  # two rows have one code; nothing is gained and nothing is wrong
    return everything, everything


_ODD, _SHIFT = np.uint64(0x9E3779B97F4A7C15), np.uint64(32)
"""They mix the bits of a code."""


def boxes(bodies: Bodies, index: IntArray) -> Boxes:
    """Prisms of some bodies at their first pose."""
    return Boxes(bodies.corners[index], bodies.z_min[index], bodies.z_max[index])
