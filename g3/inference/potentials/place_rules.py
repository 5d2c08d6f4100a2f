"""Rules about places: on the ground, and on which side of a thing."""

from __future__ import annotations

from collections.abc import Sequence
from math import log

import numpy as np

from g3.actions.arrangements import facing, turned
from g3.actions.grounding_candidates import are_free, carrier
from g3.actions.robot_state import centres, is_load
from g3.features.bodies import IntArray
from g3.features.factor_batch import FactorBatch
from g3.features.sets.named import named, says
from g3.features.sets.ranks import local_centres
from g3.geometry.footprints import centre
from g3.geometry.plane import BoolArray, convex_hull, point_gap, rotate
from g3.geometry.relations import LEVEL_M
from g3.groundings import FloatArray, PhysicalObject, Place, Prism
from g3.inference.potentials.cases import FactorCase, SpotCase
from g3.inference.potentials.potential_registry import HARD, Measured, potential
from g3.language.lexicon.concepts import BESIDE, CONCEPTS, concepts
from g3.language.lexicon.field_words import field_words
from g3.language.lexicon.tables import WORDS
from g3.sdc.clauses import SDC, all_words

_WAYS = np.array([[0.0, 1.0], [0.0, -1.0], [-1.0, 0.0], [1.0, 0.0]])
"""Where the left, right, front and far side of a thing are, seen along the first axis."""
SAME_SPOT_M = 1.5
"""Nearer than this to where it stood a load has not been moved."""
ROBOT_M = 1.5
"""Nearer than this to where the robot is it can put nothing."""
AWAY_M = 5.0
"""What is only told by the robot is the less likely meant by e, each time it is so much further."""
ASIDE = 0.5
"""A place is on a side of a thing if the cosine of its direction to that side is no smaller."""


def on_ground(words: SDC, relation: SDC) -> bool:
    """Check that words say that something is to be on the ground: not on the truck but beside it.

    Parameters
    ----------
    words
        The clause whose words may name the floor.
    relation
        The clause whose relation may put it beside something.
    """
    if WORDS["floor"].intersection(field_words(all_words(words))):
        return True
    said = concepts(field_words(relation.relation))
    return "on" not in said and bool(said & BESIDE)


def is_on_top(sdc: SDC) -> bool:
    """Check that words say that something is to be on a thing: on the truck, not on its left."""
    said = concepts(field_words(sdc.relation))
    return "on" in said and not said & (BESIDE - {"near", "between"})


def _about_thing(batch: FactorBatch) -> BoolArray:
    """Check that each row's landmark is a thing, not the robot nor a place; shape (n,)."""
    mark = batch.landmark
    labelled = batch.bodies.labels[mark].any(axis=1)
    result: BoolArray = (mark >= 0) & (mark != batch.agent_body) & labelled
    return result


@potential("floor", kind="factor", types=("PLACE",), weight=log(0.05))
def floor(case: FactorCase) -> Measured:
    """A place on the ground, or beside something, isn't on top of a thing."""
    return on_ground(case.sdc, case.sdc) and _is_high(case)


@potential(
    "on-top", kind="factor", types=("PLACE",), roles=("figure", "landmark"), weight=log(0.05)
)
def on_top(case: FactorCase) -> Measured:
    """A place "on the truck" is on top of it; so is "truck" alone, which is one."""
    if on_ground(case.sdc, case.sdc):
        return False
    if not case.sdc.relation and case.sdc.landmark1:
        return _about_deck(case) & ~_is_high(case)
    return is_on_top(case.sdc) and _about_thing(case.batch) & ~_is_high(case)


def _about_deck(case: FactorCase) -> BoolArray:
    """Check that each row's landmark is what loads stand on, but no load itself; shape (n,)."""
    state, surfaces = case.problem.state, case.problem.surfaces
    deck = np.zeros(len(case.batch.bodies.z_min) + 1, dtype=bool)
    for i, thing in enumerate(state.context.objects):
        deck[i] = thing.id in surfaces and not is_load(state, thing.id)
    result: BoolArray = deck[case.batch.landmark]
    return result


def _is_high(case: FactorCase) -> BoolArray:
    """Find the rows whose places aren't on the ground."""
    high: BoolArray = case.batch.bodies.z_min[case.batch.figure] > case.floor + LEVEL_M
    return high


@potential("place-side", kind="factor", types=("PLACE",), weight=log(0.05))
def place_side(case: FactorCase) -> Measured:
    """A place is on the side of its landmark that words name: "to the right of the pallet".

    The right of a pallet is as seen by someone who faces the row of its like; its front is the side
    of who speaks, and the far side is behind it. The right of several things is beyond all of
    them. The robot has its own sides. Where there is no landmark they are those of what goes there,
    as the robot sees it: "two metres to the right".
    """
    batch = case.batch
    wanted = _sides(batch)
    bodies, mark = batch.bodies, np.where(batch.landmark < 0, batch.agent_body, batch.landmark)
    robot = mark == batch.agent_body
    applies = wanted.sum(axis=1) == 1
    applies &= robot | bodies.labels[mark].any(axis=1)
    applies &= (bodies.count[mark] == 1) | ~wanted[:, 2:].any(axis=1)
    if not applies.any():
        return False
    middle, place = local_centres(batch, mark), local_centres(batch, batch.figure)
    middle = np.where((batch.landmark < 0)[:, None], _seen(batch, case.origin), middle)
    peers = local_centres(batch, batch.peers)
    alike = (bodies.labels[batch.peers] & bodies.labels[mark][:, None]).any(axis=2)
    ahead, _ = facing(middle, peers, alike & (batch.peers != mark[:, None]))
    sight = middle / np.maximum(np.linalg.norm(middle, axis=1, keepdims=True), 1e-9)
    ahead = np.where(wanted[:, 2:].any(axis=1, keepdims=True), sight, ahead)
    ahead = np.where(robot[:, None], np.array([1.0, 0.0]), ahead)
    way = wanted @ _WAYS
    way[robot, 0] *= -1
    off = turned(place - middle, ahead)
    along = (off * way).sum(axis=1)
    wrong = along < ASIDE * np.linalg.norm(off, axis=1)
    several = bodies.count[mark] > 1
    if several.any():
        beyond = np.nan_to_num(_beyond(batch, mark, place, ahead, way), nan=np.inf).min(axis=1)
        wrong |= several & (beyond < 0)
    result: BoolArray = applies & wrong
    return result


@potential("near", kind="factor", types=("PLACE",), weight=-1.0)
def near(case: FactorCase) -> FloatArray:
    """A place without a landmark, or with the robot as its landmark, is near."""
    bare, way = _way_to(case)
    robot = case.batch.landmark == case.batch.agent_body
    return np.where(bare | robot, np.linalg.norm(way, axis=1) / AWAY_M, 0.0)


@potential("ahead", kind="factor", types=("PLACE",), weight=-1.0)
def ahead(case: FactorCase) -> FloatArray:
    """A place without a landmark is ahead rather than aside, and aside rather than behind."""
    bare, way = _way_to(case)
    away = np.linalg.norm(way, axis=1)
    return np.where(bare, 1 - way[:, 0] / np.maximum(away, 1e-9), 0.0)


def _way_to(case: FactorCase) -> tuple[BoolArray, FloatArray]:
    """Return the rows without a landmark, (n,), and the way to each row's place, (n, 2).

    It begins at the robot, or without a landmark where what goes there is.
    """
    batch = case.batch
    bare = batch.landmark < 0
    place = local_centres(batch, batch.figure)
    return bare, np.where(bare[:, None], place - _seen(batch, case.origin), place)


def _seen(batch: FactorBatch, origin: FloatArray | None) -> FloatArray:
    """A point as the robot sees it, shape (n, 2); the robot itself for None."""
    if origin is None:
        return np.zeros((len(batch), 2))
    return rotate(origin - batch.agent[:, :2], -batch.agent[:, 2])


def _sides(batch: FactorBatch) -> BoolArray:
    """Find the sides that each row's relation names: left, right, front, far; shape (n, 4).

    "At the end of the row to your right" is on the right whatever "to your right" belongs to.
    """
    ends = says(batch, WORDS["ends"])[:, None]
    sides = np.where(ends, named(batch, ("relation", "landmark")), named(batch, ("relation",)))
    sides = sides[:, [CONCEPTS.index(s) for s in ("left", "right", "front")]]
    return np.column_stack((sides, says(batch, WORDS["behind"])))


def _beyond(
    batch: FactorBatch, mark: IntArray, place: FloatArray, ahead: FloatArray, way: FloatArray
) -> FloatArray:
    """Return how much further places are than each of their landmark's things; (n, members)."""
    offset = batch.bodies.members[mark] - batch.agent[:, None, :2]
    local = rotate(offset, np.broadcast_to(-batch.agent[:, 2, None], offset.shape[:2]))
    off = turned(place[:, None] - local, ahead[:, None])
    further: FloatArray = (off * way[:, None]).sum(axis=-1)
    return further


@potential("room", kind="spot", types=("PLACE",), roles=("figure", "theme"), weight=HARD)
def room(case: SpotCase) -> BoolArray:
    """Nothing stands where a load is put."""
    state, load = case.problem.state, case.problem.load
    return ~are_free(case.spots, state, load)


@potential("off-robot", kind="spot", types=("PLACE",), roles=("figure", "theme"), weight=HARD)
def off_robot(case: SpotCase) -> Measured:
    """The robot doesn't stand where it puts down what it has on its forks."""
    if case.problem.load != case.problem.state.held:
        return False  # it drives away before it comes back with the load
    middles = centres([spot.prism for spot in case.spots])
    near: BoolArray = np.linalg.norm(middles - case.problem.state.pose[:2], axis=1) <= ROBOT_M
    return near


@potential("elsewhere", kind="spot", types=("PLACE",), roles=("figure", "theme"), weight=HARD)
def elsewhere(case: SpotCase) -> Measured:
    """A load isn't put where it stands, nor on what it stands on."""
    state, load = case.problem.state, case.problem.load
    if load is None or load == state.held:
        return False
    return stands_at(case.spots, state.thing(load), carrier(state, load))


def _gaps(points: FloatArray, prism: Prism) -> FloatArray:
    """Return the distances of points (n, 2) from a footprint, 0 inside; shape (n,)."""
    gaps: FloatArray = point_gap(points[None], convex_hull(prism.xy)[None])[0]
    return gaps


def stands_at(
    places: Sequence[Place], thing: PhysicalObject, under: PhysicalObject | None
) -> BoolArray:
    """Find the places on the carrier of a thing, or for one on the ground at its spot."""
    middles = centres([place.prism for place in places])
    if under is None:
        near: BoolArray = np.linalg.norm(middles - centre(thing.prism), axis=1) < SAME_SPOT_M
        return near
    bottoms = np.array([place.prism.z_min for place in places])
    level = np.abs(under.prism.z_max - bottoms) < LEVEL_M
    return level & (_gaps(middles, under.prism) <= 0)
