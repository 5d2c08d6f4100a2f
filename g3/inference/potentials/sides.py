"""What words single out among things alike: "the leftmost pallet", "the second from the right".

People turn to face what they speak of: the leftmost pallet of a row behind the robot is the
leftmost for who faces the row, not for who looks ahead and has it at the back. Of things all
around they speak as they stand.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log

import numpy as np

from g3.actions.facing import facing, lines, turned
from g3.features.factor_batch import FactorBatch, WordField
from g3.features.sets.named import named
from g3.features.sets.order import DIRECTIONS, all_ordinals, extents, ordinals, rivals
from g3.features.sets.ranks import SAME_PLACE_M, is_robot, local_centres
from g3.geometry.plane import BoolArray
from g3.groundings import FloatArray
from g3.inference.potentials.cases import FactorCase
from g3.inference.potentials.potential_registry import potential
from g3.language.discourse.groups import group
from g3.language.lexicon.concepts import CONCEPTS, concepts
from g3.language.lexicon.word_sets import ENDS, REAR
from g3.sdc.clauses import SDC

CENTRAL = 0.5
"""What stands in the middle is at most so far from the middle of all, as a share of the others."""
DOUBTFUL = 0.3
"""Of things all around one is further to a side if the sines of their directions differ so much."""
_FIELDS: tuple[WordField, ...] = ("figure", "relation")


@dataclass(frozen=True, slots=True, eq=False)
class _SingledOut:
    """Which rows' figures aren't those that words single out, by what singles them out; each (n,).

    Words do so that have no landmark but the robot, or the row that the thing stands in. "The
    second from the left" isn't the leftmost, "the second on the left" is counted from there too,
    and on "the far left" it's the side that counts.
    """

    side: BoolArray
    number: BoolArray
    middle: BoolArray
    aside: BoolArray


def _singled_out(batch: FactorBatch) -> _SingledOut | None:
    free = (batch.landmark < 0) | (batch.landmark == batch.agent_body) | is_member(batch)
    wanted = named(batch, ("figure",)) | (named(batch, _FIELDS) & free[:, None])
    direction = wanted[:, [CONCEPTS.index(c) for c in DIRECTIONS]]
    rear = _says(batch, REAR, batch.landmark < 0)
    direction[:, DIRECTIONS.index("back")] &= ~rear
    last = wanted[:, CONCEPTS.index("last")]
    aside = direction[:, :4].any(axis=1)
    end = last & ~aside & ~direction[:, 4:].any(axis=1) & _says(batch, ENDS, free)
    direction[:, DIRECTIONS.index("far")] |= last | rear
    direction[:, 4:] &= ~aside[:, None]
    number = np.where(free, ordinals(batch, _FIELDS), ordinals(batch, ("figure",)))
    inner = [concepts(w.get("landmark", ())) == {"between"} for w in batch.words]
    middle = named(batch, ("figure",))[:, CONCEPTS.index("between")] | np.array(inner)[batch.factor]
    if not (direction.any() or number.any() or middle.any()):
        return None
    rival = rivals(batch)
    ahead = _further(batch, rival)
    beaten = (direction & (ahead > 0)).any(axis=1)
    outer = np.zeros(len(batch), dtype=bool)
    if middle.any() or end.any():
        along, straight, central = _arranged(batch, rival)
        beaten = np.where(end & straight, along.all(axis=1), beaten)
        left, right = (ahead[:, DIRECTIONS.index(side)] for side in ("left", "right"))
        off = np.where(straight, along[:, 0] - along[:, 1], left - right)
        outer = middle & np.where(np.isnan(central), np.abs(off) > 1, central == 0)
    counted = direction.copy()
    counted[:, DIRECTIONS.index("near")] |= ~aside
    other = ~(counted & (ahead == number[:, None] - 1)).any(axis=1)
    applies = rival.any(axis=1) & ~is_robot(batch) & (batch.bodies.count[batch.figure] == 1)
    plain = applies & (number == 0)
    return _SingledOut(
        plain & beaten, applies & (number > 0) & other, plain & outer & ~beaten, aside
    )


def _says(batch: FactorBatch, wanted: frozenset[str], free: BoolArray) -> BoolArray:
    """Whether each row's noun has one of some words, or its relation where that's free; (n,)."""
    own, relation = (
        np.array([bool(wanted.intersection(w.get(f, ()))) for w in batch.words]) for f in _FIELDS
    )
    result: BoolArray = own[batch.factor] | (relation[batch.factor] & free)
    return result


def _arranged(batch: FactorBatch, rival: BoolArray) -> tuple[FloatArray, BoolArray, FloatArray]:
    """How figures stand among their rivals, whoever looks at them.

    Returns
    -------
    along : FloatArray
        How many rivals are further along the line on which all lie, each way; shape (n, 2).
    straight : BoolArray
        Whether all are a row, shape (n,).
    central : FloatArray
        Whether the figure is the one in the middle of all, NaN where none is; shape (n,).
    """
    own, others = local_centres(batch, batch.figure), local_centres(batch, batch.peers)
    points = np.concatenate((own[:, None], others), axis=1)
    seen = np.column_stack((np.ones(len(batch), dtype=bool), rival))
    middle, axes, straight = lines(points, seen)
    offset = points - middle[:, None]
    place = (offset * axes[:, None, :, 1]).sum(axis=-1)
    ahead = place[:, 1:] - place[:, :1]
    along = np.column_stack([(rival & (way * ahead > SAME_PLACE_M)).sum(axis=1) for way in (1, -1)])
    away = np.where(seen, np.linalg.norm(offset, axis=-1), np.inf)
    first, second = np.sort(away, axis=1)[:, :2].T
    clear = ~straight & np.isfinite(second) & (first < CENTRAL * second)
    return along, straight, np.where(clear, away[:, 0] == first, np.nan)


def _wrong(case: FactorCase, which: str) -> FloatArray:
    """Rows that words don't single out, sides twice.

    How things lie for the robot, which is what the model has learned of sides, says little of how
    they lie in a row.
    """
    if case.is_part:
        return case.nothing
    found = case.own_batch.once(_singled_out, _singled_out)
    return case.nothing if found is None else getattr(found, which) * (1.0 + found.aside)


@potential("side", kind="factor", types=("OBJECT",), weight=log(0.05))
def side(case: FactorCase) -> FloatArray:
    """Nothing alike is further to the side that words name: "the leftmost pallet"."""
    return _wrong(case, "side")


@potential("ordinal", kind="factor", types=("OBJECT",), weight=log(0.05))
def ordinal(case: FactorCase) -> FloatArray:
    """A thing stands where words count to: "the second from the left"."""
    return _wrong(case, "number")


@potential("middle", kind="factor", types=("OBJECT",), weight=log(0.05))
def middle(case: FactorCase) -> FloatArray:
    """As many things alike are on the one side as on the other: "the middle pallet"."""
    return _wrong(case, "middle")


@potential("counted-things", kind="factor", types=("OBJECT",), weight=3 * log(0.05))
def counted_things(case: FactorCase) -> FloatArray:
    """Several things are those that words count among all alike: "the first and second".

    Counted from the side that is named, or from the robot: "the three leftmost", "the first two".
    """
    total, batch = case.nothing, case.own_batch
    bodies = batch.bodies
    numbers = _numbers(case.sdc, batch)
    several = np.array([len(own) > 1 for own in numbers])[batch.factor]
    rows = np.flatnonzero(several & (bodies.count[batch.figure] > 1))
    if not len(rows) or case.is_part:
        return total
    wanted = named(batch, _FIELDS)[:, [CONCEPTS.index(c) for c in DIRECTIONS]]
    wanted[:, DIRECTIONS.index("near")] |= ~wanted.any(axis=1)
    alike = (bodies.labels[batch.peers] == bodies.labels[batch.figure][:, None]).all(axis=2)
    alike &= (batch.peers >= 0) & (bodies.count[batch.peers] == 1)
    middles, others = local_centres(batch, batch.figure), local_centres(batch, batch.peers)
    ahead, _ = facing(middles, others, alike)
    extent = np.where(alike[..., None], _extents(others, turned(others, ahead[:, None])), -np.inf)
    for i in rows:
        order = np.argsort(-extent[i, :, wanted[i].argmax()], kind="stable")[: alike[i].sum()]
        counted = bodies.centre[batch.peers[i, order]]
        members = bodies.members[batch.figure[i]]
        gap = np.linalg.norm(members[:, None] - counted, axis=-1)
        _, rank = np.nonzero(gap < SAME_PLACE_M)
        total[i] = set((rank + 1).tolist()) != numbers[batch.factor[i]]
    return total


def _numbers(sdc: SDC, batch: FactorBatch) -> list[frozenset[int]]:
    """The places, from 1, that the words of each factor count to."""
    several = frozenset(range(1, (group(sdc).count or 0) + 1))
    own: tuple[WordField, ...] = ("figure",) if sdc.landmark1 else _FIELDS
    named_by = [concepts(word for f in own for word in words.get(f, ())) for words in batch.words]
    return [
        several if told == {1} or (not told and said & set(DIRECTIONS)) else told
        for told, said in zip(all_ordinals(batch, "figure"), named_by, strict=True)
    ]


def is_member(batch: FactorBatch) -> BoolArray:
    """Whether each row's figure is one of the several things that its landmark is; shape (n,)."""
    several = (batch.landmark >= 0) & (batch.bodies.count[batch.landmark] > 1)
    members = batch.bodies.members[batch.landmark]
    away = np.linalg.norm(members - batch.bodies.centre[batch.figure][:, None], axis=-1)
    result: BoolArray = several & (away < SAME_PLACE_M).any(axis=1)
    return result


def _further(batch: FactorBatch, rival: BoolArray) -> FloatArray:
    """How many rivals are further in each direction, as seen facing all, (n, directions)."""
    own, others = local_centres(batch, batch.figure), local_centres(batch, batch.peers)
    faced, around = facing(own, others, rival)
    near = _extents(own, turned(own, faced))
    far = _extents(others, turned(others, faced[:, None]))
    further: BoolArray = rival[..., None] & (far > near[:, None] + SAME_PLACE_M)
    sine, sines = (p[..., 1] / np.maximum(np.linalg.norm(p, axis=-1), 1e-9) for p in (own, others))
    doubtful = around[:, None] & (np.abs(sines - sine[:, None]) < DOUBTFUL)
    further[..., :2] &= ~doubtful[..., None]
    count: FloatArray = further.sum(axis=1, dtype=float)
    return count


def _extents(local: FloatArray, faced: FloatArray) -> FloatArray:
    """How far points lie in each direction; ahead is where the robot looks, not how far.

    Parameters
    ----------
    local, faced
        Points in the robot's frame and in that of who faces them, shape (..., 2).
    """
    extent = extents(faced)
    angle = np.arctan2(np.abs(local[..., 1]), local[..., 0])
    extent[..., DIRECTIONS.index("front")] = -angle
    extent[..., DIRECTIONS.index("back")] = angle
    return extent
