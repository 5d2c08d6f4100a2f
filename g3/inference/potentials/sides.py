"""Things that words single out among others alike: "the leftmost pallet", "the second one".

People turn to face what they speak of: the leftmost pallet of a row behind the robot is the
leftmost for who faces the row, not for who looks ahead and has it at the back. Of things all
around they speak as they stand.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import log

import numpy as np

from g3.actions.arrangements import facing, lines, turned
from g3.actions.robot_state import is_load
from g3.features.factor_batch import FactorBatch, WordField
from g3.features.sets.named import named, says
from g3.features.sets.order import DIRECTIONS, all_ordinals, extents, ordinals, rivals
from g3.features.sets.ranks import SAME_PLACE_M, is_member, is_robot, local_centres
from g3.geometry.plane import BoolArray
from g3.groundings import FloatArray
from g3.inference.potentials.cases import FactorCase
from g3.inference.potentials.potential_registry import potential
from g3.inference.problem.clause_roles import handled_nodes, told_standing
from g3.language.discourse.groups import group, noun_leaf, noun_words
from g3.language.lexicon.concepts import CONCEPTS, SIDES, Concept, concepts
from g3.language.lexicon.field_words import field_words, normalise
from g3.language.lexicon.tables import WORDS
from g3.sdc.clauses import SDC

CENTRAL = 0.5
"""What stands in the middle is at most so far from the middle of all, as a share of the others."""
DOUBTFUL = 0.3
"""Of things all around one is further to a side if the sines of their directions differ so much."""
_DEPTHS: tuple[Concept, ...] = ("near", "far")
_FIELDS: tuple[WordField, ...] = ("figure", "relation")


@dataclass(frozen=True, slots=True, eq=False)
class _SingledOut:
    """Rows whose figures words don't single out, by the way of singling out; each (n,).

    Words do so that have no landmark but the robot, or the row that the thing stands in. "The
    second from the left" isn't the leftmost, "the second on the left" is counted from there too,
    and on "the far left" it's the side that counts. "The far one on the left" is the farthest of
    those on the robot's left.
    """

    side: BoolArray
    number: BoolArray
    middle: BoolArray
    aside: BoolArray


def _singled_out(batch: FactorBatch, depth: Concept | None) -> _SingledOut | None:
    free = (batch.landmark < 0) | (batch.landmark == batch.agent_body) | is_member(batch)
    wanted = named(batch, ("figure",)) | (named(batch, _FIELDS) & free[:, None])
    direction = wanted[:, [CONCEPTS.index(c) for c in DIRECTIONS]]
    away = np.zeros((len(batch), 1 + batch.peers.shape[1]), dtype=bool)
    if depth:
        away = _away(batch, direction)
        direction = np.array(DIRECTIONS) == np.full((len(batch), 1), depth)
    rear = _says(batch, WORDS["rear"], batch.landmark < 0)
    direction[:, DIRECTIONS.index("back")] &= ~rear
    last = wanted[:, CONCEPTS.index("last")]
    aside = direction[:, :4].any(axis=1)
    end = last & ~aside & ~direction[:, 4:].any(axis=1) & _says(batch, WORDS["ends"], free)
    direction[:, DIRECTIONS.index("far")] |= last | rear
    direction[:, 4:] &= ~aside[:, None]
    number = np.where(free, ordinals(batch, _FIELDS), ordinals(batch, ("figure",)))
    inner = [concepts(w.get("landmark", ())) == {"between"} for w in batch.words]
    middle = named(batch, ("figure",))[:, CONCEPTS.index("between")] | np.array(inner)[batch.factor]
    if not (direction.any() or number.any() or middle.any()):
        return None
    rival = rivals(batch) & ~away[:, 1:]
    ahead = _further(batch, rival)
    beaten = (direction & (ahead > 0)).any(axis=1) | away[:, 0]
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
    applies = (
        (rival.any(axis=1) | away[:, 0])
        & ~is_robot(batch)
        & (batch.bodies.count[batch.figure] == 1)
    )
    plain = applies & (number == 0)
    return _SingledOut(
        plain & beaten, applies & (number > 0) & other, plain & outer & ~beaten, aside
    )


def _depth(sdc: SDC) -> Concept | None:
    """Check that a noun says near or far, its relation alone a side: "the near one on the left"."""
    said = {c for c in concepts(field_words(noun_leaf(sdc).words)) if c in DIRECTIONS}
    sides = concepts(field_words(sdc.relation)) & {"left", "right"}
    if not sdc.figure or sdc.landmark1 or len(sides) != 1:
        return None
    return next((c for c in _DEPTHS if said == {c}), None)


def _away(batch: FactorBatch, direction: BoolArray) -> BoolArray:
    """Check that figures and peers are on the other side of the robot than is named; (n, 1 + p)."""
    middles = local_centres(batch, batch.figure)[:, None], local_centres(batch, batch.peers)
    leftward = np.concatenate(middles, axis=1)[..., 1]
    away: BoolArray = np.where(direction[:, :1], leftward, -leftward) <= 0
    return away


def _says(batch: FactorBatch, wanted: frozenset[str], free: BoolArray) -> BoolArray:
    """Check that each row's noun has one of some words, or its relation where that's free; (n,)."""
    return says(batch, wanted, "figure") | (says(batch, wanted) & free)


def _arranged(batch: FactorBatch, rival: BoolArray) -> tuple[FloatArray, BoolArray, FloatArray]:
    """Return how figures stand among their rivals, whoever looks at them.

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
    depth = _depth(case.sdc)
    compared = case.own_batch.once((_compared, case.node), lambda _: _compared(case))
    found = compared.once((_singled_out, depth), lambda batch: _singled_out(batch, depth))
    return case.nothing if found is None else getattr(found, which) * (1.0 + found.aside)


def _names_any_load(case: FactorCase) -> bool:
    """Check that a clause is what is handled, and its noun names no kind: "the one on the left"."""
    noun = {normalise(word) for word in noun_words(case.sdc)[-1:]}
    unnamed = noun & WORDS["generic"] or (noun & WORDS["ones"] and not case.tree.left_out(case.sdc))
    return bool(unnamed) and case.node in case.tree.once(handled_nodes)


def _compared(case: FactorCase) -> FactorBatch:
    """The rows with those peers alone that a figure is compared with.

    "The right one on the truck" is compared with what stands there, and whatever is to be lifted
    with what can be. "On the right end of the truck" tells nothing but the side of what is on it.
    """
    batch, problem = case.own_batch, case.problem
    standing, any_load = case.node in case.tree.once(told_standing), _names_any_load(case)
    aside = _says_end(case.sdc)
    if not (standing or any_load or aside):
        return batch
    ids = [o.id for o in problem.state.context.objects]
    under = np.array([ids.index(problem.carriers.get(own, own)) for own in ids])
    figure, peer = (np.minimum(body, len(ids) - 1) for body in (batch.figure, batch.peers))
    compared: BoolArray = batch.peers < len(ids)
    if any_load:
        compared &= np.array([is_load(problem.state, own) for own in ids])[peer]
    level = np.where(under == np.arange(len(ids)), -1, under)
    aboard = aside & (level[figure] >= 0) & (level[figure] == batch.landmark)
    same = level[peer] == level[figure][:, None]
    compared &= same | ~(standing | aboard[:, None])
    return replace(
        batch,
        landmark=np.where(aboard, -1, batch.landmark),
        peers=np.where(compared, batch.peers, -1),
    )


def _says_end(sdc: SDC) -> bool:
    """Check that a relation names an end or a side that something is on: "on the right end of"."""
    words = field_words(sdc.relation)
    said = concepts(words)
    return bool(
        sdc.landmark1 and "on" in said and said & SIDES and WORDS["parts"].intersection(words)
    )


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


def _further(batch: FactorBatch, rival: BoolArray) -> FloatArray:
    """Count the rivals that are further in each direction, as seen facing all, (n, directions)."""
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
    """Return how far points lie in each direction; ahead is where the robot looks, not how far.

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
