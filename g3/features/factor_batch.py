"""Input of features: a batch of factors, each with one candidate grounding per argument."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, Literal, TypeVar, get_args

import numpy as np
import numpy.typing as npt

from g3.features.bodies import Bodies, IntArray
from g3.geometry.plane import area, centroid
from g3.groundings import FloatArray
from g3.short_repr import short_repr

Role = Literal["figure", "landmark", "theme", "goal"]
"""Role of a grounding in its factor.

``figure``: the thing, place or trajectory that the clause denotes. ``landmark``: what it
is related to (OBJECT, PLACE and PATH clauses). ``theme``: the object that an EVENT acts
on. ``goal``: where the EVENT leads, the grounding of its PLACE or of its PATH's landmark.
"""

WordField = Literal["figure", "name", "relation", "goal", "landmark"]
"""Source of words, which is the figure's, those same words as written ("name"), the relation's,
those of the relation of the PATH or PLACE in an EVENT, or those of the landmarks (which the paper's
factors don't see)."""

T = TypeVar("T")

FieldWords = dict[WordField, tuple[str, ...]]


@short_repr
@dataclass(frozen=True, slots=True)
class Boxes:
    """n upright prisms, in metres.

    Parameters
    ----------
    corners
        Footprints, shape (n, k, 2).
    z_min, z_max
        Shape (n,).
    centre, area
        Centres and areas of the footprints, shapes (n, 2) and (n,).
    """

    corners: FloatArray
    z_min: FloatArray
    z_max: FloatArray
    centre: FloatArray
    area: FloatArray


@short_repr
@dataclass(frozen=True, slots=True)
class FactorBatch:
    """n factor candidates.

    Parameters
    ----------
    bodies
        The groundings that the rows refer to.
    type
        Index into :data:`g3.sdc.clauses.SDC_TYPES`, shape (n,).
    figure, landmark, theme, goal
        Index of the body in the role, -1 where there is none, shape (n,).
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
        Index of a row's word entry, shape (n,).
    words
        The words of each factor's fields.
    known
        Results for the batch that one feature set computed and others use too.
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
        """Return the batch of some of the rows, with the words of their factors only."""
        factors = self.factor[rows]
        first, factor = distinct(factors)
        return FactorBatch(
            bodies=self.bodies,
            words=[self.words[i] for i in factors[first]],
            factor=factor,
            **{name: _rows(getattr(self, name), rows) for name in _GEOMETRY},
        )

    def once(self, name: Hashable, compute: Callable[[FactorBatch], T]) -> T:
        """Return a function's result for the batch, computed on first use.

        Several feature sets share it, so nobody may change it.
        """
        if name not in self.known:
            self.known[name] = compute(self)
        result: T = self.known[name]
        return result

    def shared(
        self, compute: Callable[[FactorBatch], FloatArray], *roles: Role, words: bool = False
    ) -> FloatArray:
        """Values (n, ...) of a function, computed once for rows that are equal in what it sees.

        As with :meth:`once`, nobody may change them.

        Parameters
        ----------
        compute
            It sees the scene, the groundings in some roles, and words if `words` is set.
        roles
            The roles that it sees.
        """
        different, row = self.once((roles, words), lambda batch: _different(batch, roles, words))
        result = different.once(compute, compute)
        return result if row is None else result.take(row, axis=0)

    def boxes(self, role: Role) -> Boxes:
        """Prisms of the bodies in a role, at their first pose."""
        return self.once(("boxes", role), lambda batch: boxes(batch.bodies, batch.role(role)))

    def all_boxes(self) -> Boxes:
        """Prisms of all bodies at their first pose."""
        return Boxes(*(getattr(self.bodies, f.name) for f in fields(Boxes)))


ROLES: tuple[Role, ...] = get_args(Role)

_GEOMETRY = tuple(
    f.name for f in fields(FactorBatch) if f.name not in ("bodies", "factor", "words", "known")
)
"""All that says where things are, a value or a row of them for each row of the batch."""

_SCENE = tuple(name for name in _GEOMETRY if name not in ROLES)


def _rows(values: npt.NDArray[Any], rows: IntArray) -> npt.NDArray[Any]:
    if values.strides[0] == 0 and len(values):
        if len(rows) <= len(values):
            return values[: len(rows)]
        return np.broadcast_to(values[0], (len(rows), *values.shape[1:]))
    return values.take(rows, axis=0)


def _different(
    batch: FactorBatch, roles: tuple[Role, ...], words: bool
) -> tuple[FactorBatch, IntArray | None]:
    """Return the rows that differ in some roles, or words, and the index of each row among them.

    They have nothing in other roles. Where all rows differ, they are as they were: None.
    """
    columns = [batch.role(role) + 1 for role in roles] + ([batch.factor] if words else [])
    scenes = batch.once("scenes", _scenes)
    first, row = _equal_rows(scenes, columns)
    taken = {name: getattr(batch, name) for name in _GEOMETRY}
    factor = batch.factor
    all_differ = len(first) == len(batch)
    if not all_differ:
        taken = {name: _rows(values, first) for name, values in taken.items()}
        factor, scenes = factor[first], scenes[first]
    unseen = np.broadcast_to(np.intp(-1), len(first))
    taken |= {role: unseen for role in ROLES if role not in roles}
    used: Sequence[FieldWords] = batch.words
    if not words:
        factor, used = np.zeros(len(first), dtype=np.intp), ({},)
    different = FactorBatch(batch.bodies, factor=factor, words=used, **taken)
    different.known["scenes"] = scenes
    return different, None if all_differ else row


def _scenes(batch: FactorBatch) -> IntArray:
    """Return the index of each row's scene, shape (n,)."""
    values = [getattr(batch, name) for name in _SCENE]
    differing = [v.reshape(len(batch), -1) for v in values if v.strides[0] != 0]
    if not differing or not len(batch):
        return np.zeros(len(batch), dtype=np.intp)
    table = np.column_stack([v.astype(float) for v in differing])
    bytes_of_row = np.ascontiguousarray(table).view(f"V{table.itemsize * table.shape[1]}")
    number: dict[bytes, int] = {}
    return np.array([number.setdefault(row, len(number)) for row in bytes_of_row.ravel().tolist()])


def _equal_rows(code: IntArray, columns: Sequence[IntArray]) -> tuple[IntArray, IntArray]:
    """Return the first index of each different row of a table, and each row's index among these."""
    first = np.arange(len(code))
    for column in columns:
        first, code = distinct(code * (column.max(initial=0) + 1) + column)
    return first, code


SPARSE = 64
"""Largest number, relative to the count of all, for which a table replaces sorting."""


def distinct(numbers: IntArray) -> tuple[IntArray, IntArray]:
    """Return the first index of each distinct number of (n,), by size, and each one's rank.

    None is negative. ``np.unique`` finds the same by sorting.
    """
    size = int(numbers.max(initial=-1)) + 1
    if size > SPARSE * len(numbers):
        _, first, which = np.unique(numbers, return_index=True, return_inverse=True)
        return first, which.reshape(-1)
    place = np.full(size, -1)
    # Of several rows with a number the last that is written stays.
    place[numbers[::-1]] = np.arange(len(numbers) - 1, -1, -1)
    used = np.flatnonzero(place >= 0)
    first = place[used]
    place[used] = np.arange(len(used))
    return first, place[numbers]


def boxes(bodies: Bodies, index: IntArray) -> Boxes:
    """Prisms of some bodies at their first pose."""
    return Boxes(*(getattr(bodies, f.name)[index] for f in fields(Boxes)))


def stacked(parts: Sequence[Boxes]) -> Boxes:
    """Prisms one after the other, to be looked at together."""
    return Boxes(*(np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(Boxes)))


def measured(corners: FloatArray, z_min: FloatArray, z_max: FloatArray) -> Boxes:
    """Prisms with the centres and areas of their footprints."""
    return Boxes(corners, z_min, z_max, centroid(corners), area(corners))
