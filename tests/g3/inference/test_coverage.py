"""What people ask for is among the candidates, and the search reaches it: over generated worlds.

What is possible is found by trying all points of a fine grid, by rules that know nothing of how
candidates are made.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from g3.geometry.footprints import centre
from g3.geometry.plane import BoolArray, convex_hull, point_gap, rotate
from g3.groundings import Context, FloatArray, PhysicalObject, Prism
from g3.inference.grounder import Grounder
from g3.sdc.sdc_notation import parse_brackets
from tests.g3.actions.yards import box, forklift
from tests.g3.inference.oracle_cost import OracleCost

LOAD_M, HEIGHT_M = 1.2, 0.7
HALF_M = LOAD_M / 2
ROOM_M = 1.2
"""On the ground a load needs so much room around its middle, on a deck half its side and a bit."""
DECK_ROOM_M = 0.9
NEAR_M = 2.3
"""Beside a thing is no further from its side."""
STEP_M = 0.2
DECK = (0.4, 0.85)

ANGLES = st.floats(-3.1, 3.1)
LEVELS = ("ground", "deck", "stack")
STARTS = ("near", "far", "close", "loaded")


@dataclass(frozen=True)
class World:
    """A yard: the mark, what is under it, the load that is to go there, and the robot."""

    context: Context
    mark: PhysicalObject
    under: PhysicalObject | None

    @property
    def load(self) -> PhysicalObject:
        return next(o for o in self.context.objects if o.id == "load")

    @property
    def robot(self) -> FloatArray:
        return self.context.agent.trajectory.xyz[0, :2]


def gaps(points: FloatArray, prism: Prism) -> FloatArray:
    return point_gap(points[None], convex_hull(prism.xy)[None])[0]


def depth(points: FloatArray, prism: Prism) -> FloatArray:
    """How far points (n, 2) are from the border of a footprint if inside, else 0."""
    hull = convex_hull(prism.xy)
    edges = np.roll(hull, -1, axis=0) - hull
    normal = np.column_stack((-edges[:, 1], edges[:, 0]))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return np.maximum(((points[:, None] - hull) * normal).sum(axis=-1).min(axis=1), 0.0)


def possible(world: World, points: FloatArray) -> BoolArray:
    """Whether the load could stand at points x, y, z (n, 3) on something, with room around it."""
    xy, z = points[:, :2], points[:, 2]
    on_ground = np.abs(z) < 0.1
    found = on_ground.copy()
    for thing in world.context.objects:
        if thing.id in ("load", "agent"):
            continue
        on_top = (np.abs(z - thing.prism.z_max) < 0.1) & (thing.id == "trailer")
        found |= on_top & (depth(xy, thing.prism) >= HALF_M - 0.15)
        room = np.where(on_ground, ROOM_M, DECK_ROOM_M - 0.1)
        found &= on_top | (thing.prism.z_max <= z + 0.3) | (gaps(xy, thing.prism) >= room - 1e-6)
    # Where it stands already, it isn't put.
    away = np.linalg.norm(xy - centre(world.load.prism), axis=1) > 2.0
    return found & away


def grid(around: Prism, margin: float, z: float) -> FloatArray:
    low, high = around.xy.min(axis=0) - margin, around.xy.max(axis=0) + margin
    x, y = np.meshgrid(np.arange(low[0], high[0], STEP_M), np.arange(low[1], high[1], STEP_M))
    return np.column_stack((x.ravel(), y.ravel(), np.full(x.size, z)))


def is_comfortable(right: BoolArray) -> bool:
    """Whether there is more than a splinter of room, of so many points of the grid."""
    return int(right.sum()) >= 30


@st.composite
def worlds(draw: st.DrawFn, level: str, start: str, from_deck: float | None = None) -> World:
    """Worlds with the mark on a level, and the robot at a start.

    Parameters
    ----------
    from_deck
        In which direction from the deck's heading the robot is, within half a radian; None for any.
    """
    yaw = draw(ANGLES)
    things = []
    at, bottom = np.zeros(2), 0.0
    if level != "ground":
        size = (draw(st.floats(5.0, 8.0)), draw(st.floats(1.9, 3.0 if from_deck is None else 2.5)))
        z = DECK
        if level == "stack":
            size, z = (LOAD_M, LOAD_M), (0.0, HEIGHT_M)
        name, labels = ("trailer", "trailer") if level == "deck" else ("base", "box pallet")
        under = box(name, labels, (0, 0, yaw), size, z)
        along = draw(st.floats(-1, 1)) * (size[0] / 2 - HALF_M)
        at, bottom = rotate(np.array([[along, 0.0]]), np.array([yaw]))[0], z[1]
        things.append(under)
    own = yaw if draw(st.booleans()) else draw(ANGLES)
    mark = box("mark", "crate", (*at, own), (LOAD_M, LOAD_M), (bottom, bottom + HEIGHT_M))
    way = draw(ANGLES) if from_deck is None else yaw + from_deck + draw(st.floats(-0.5, 0.5))
    return with_start(draw, start, [*things, mark], way=way)


def with_start(
    draw: Callable[..., Any],
    start: str,
    things: Sequence[PhysicalObject],
    away: float = 9.0,
    way: float | None = None,
) -> World:
    """Things about the origin, the last of them the mark, with the load and the robot somewhere."""
    way = draw(ANGLES) if way is None else way
    away = {"far": 60.0, "close": 0.0}.get(start, away)
    heading = draw(ANGLES)
    pose = (away * np.cos(way), away * np.sin(way), heading)
    load_away = max(away, 12.0) if away < 60.0 else 20.0
    load_at = (*(load_away * np.array([np.cos(way + 2), np.sin(way + 2)])), draw(ANGLES))
    lifted = 0.0
    if start == "close":
        # Less than a metre before the load that is to be lifted.
        out = HALF_M * 1.5 + 0.75 + draw(st.floats(0.1, 1.0))
        pose = (load_at[0] + out * np.cos(way), load_at[1] + out * np.sin(way), heading)
    if start == "loaded":
        load_at = (pose[0] + 1.12 * np.cos(heading), pose[1] + 1.12 * np.sin(heading), heading)
        lifted = 0.3
    load = box("load", "tire pallet", load_at, (LOAD_M, LOAD_M), (lifted, lifted + HEIGHT_M))
    context = Context("world", (*things, load, forklift(pose)), (), "agent")
    return World(context, things[-1], things[0] if len(things) > 1 else None)


PUT = "EVENT(r = Put, l = OBJ(f = the tires), l2 = PLACE(r = {relation}, l = {landmark}))"


def check_plan(context: Context, right, landmark: str, relation: str, things) -> None:
    """The best plan of a cost that knows what is right leads to where it is, x, y, z."""
    index = [o.id for o in context.objects].index("load")
    cost = OracleCost({"tire": [context.objects[index]], **things}, right, index)
    clauses = parse_brackets(PUT.format(relation=relation, landmark=landmark))
    plan = Grounder(cost).follow(clauses, context, least=0.0).plan
    assert plan is not None
    prism = plan.state.thing("load").prism
    end = np.array([[*centre(prism), prism.z_min]])
    assert right(end).all(), end


def check(world: World, right, landmark: str, relation: str, things, near: Prism, z: float) -> None:
    """The plan leads to where is right, if there is room in the world."""
    assume(is_comfortable(right(grid(near, NEAR_M + HALF_M, z))))
    check_plan(world.context, right, landmark, relation, things)


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("level", LEVELS)
@settings(max_examples=12, deadline=None)
@given(data=st.data())
def test_beside_a_thing_is_at_the_level_that_it_stands_on(level, start, data):
    world = data.draw(worlds(level, start))
    z = world.under.prism.z_max if level == "deck" else 0.0

    def right(points):
        at_level = np.abs(points[:, 2] - z) < 0.1
        beside = gaps(points[:, :2], world.mark.prism) <= NEAR_M
        return at_level & beside & possible(world, points)

    check(
        world, right, "OBJ(f = the crate)", "next to", {"crate": [world.mark]}, world.mark.prism, z
    )


SIDES = {"left": (0.0, 1.0), "right": (0.0, -1.0), "near": (-1.0, 0.0), "far": (1.0, 0.0)}
"""Sides of a thing for who looks at it from the robot."""
RELATIONS = {
    "left": "to the left of",
    "right": "to the right of",
    "near": "in front of",
    "far": "behind",
}


def seen(world: World, points: FloatArray, middle: FloatArray) -> FloatArray:
    """Points in the frame of who looks from the robot at a middle, shape (n, 2)."""
    ahead = middle - world.robot
    return rotate(points - middle, np.full(len(points), -np.arctan2(ahead[1], ahead[0])))


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("level", LEVELS)
@settings(max_examples=12, deadline=None)
@given(data=st.data())
def test_each_side_of_a_thing_is_a_place(level, side, data):
    # On a narrow deck there is room at its ends, for who looks from there.
    turn = np.pi / 2 if side in ("left", "right") else 0.0
    turn += data.draw(st.sampled_from((0.0, np.pi)))
    start = data.draw(st.sampled_from(("near", "far", "loaded") if level == "deck" else STARTS))
    world = data.draw(worlds(level, start, turn if level == "deck" else None))
    z = world.under.prism.z_max if level == "deck" else 0.0

    def there(points, degrees):
        off = seen(world, points[:, :2], centre(world.mark.prism))
        cosine = off @ np.array(SIDES[side]) / np.maximum(np.linalg.norm(off, axis=1), 1e-9)
        beside = gaps(points[:, :2], world.mark.prism) <= NEAR_M
        aside = cosine >= np.cos(np.radians(degrees))
        return (np.abs(points[:, 2] - z) < 0.1) & aside & beside & possible(world, points)

    mark = world.mark
    # A place in the very corner of what is meant isn't the only one.
    assume(is_comfortable(there(grid(mark.prism, NEAR_M + HALF_M, z), 30)))
    right = partial(there, degrees=46)
    check(world, right, "OBJ(f = the crate)", RELATIONS[side], {"crate": [mark]}, mark.prism, z)


@pytest.mark.parametrize("start", STARTS)
@settings(max_examples=12, deadline=None)
@given(data=st.data())
def test_on_a_deck_there_is_a_place_beside_what_stands_there(start, data):
    world = data.draw(worlds("deck", start))
    deck = world.under.prism

    def right(points):
        return (np.abs(points[:, 2] - deck.z_max) < 0.1) & possible(world, points)

    check(world, right, "OBJ(f = the trailer)", "on", {"trailer": [world.under]}, deck, deck.z_max)


@pytest.mark.parametrize("side", SIDES)
@settings(max_examples=12, deadline=None)
@given(data=st.data())
def test_each_side_of_a_deck_is_a_place_on_it(side, data):
    world = data.draw(worlds("deck", data.draw(st.sampled_from(STARTS))))
    world = empty(world)
    deck = world.under.prism
    z, way = deck.z_max, np.array(SIDES[side])
    fits = grid(deck, 0.0, z)
    fits = fits[depth(fits[:, :2], deck) >= HALF_M]
    outermost = (seen(world, fits[:, :2], centre(deck)) @ way).max()
    # A side is where there is more than the middle of the deck.
    assume(outermost > 0.2)

    def right(points):
        off = seen(world, points[:, :2], centre(deck)) @ way
        level = np.abs(points[:, 2] - z) < 0.1
        return level & (off >= outermost / 3) & possible(world, points)

    relation = {"near": "on the front of", "far": "on the back of"}.get(side, f"on the {side} of")
    check(world, right, "OBJ(f = the trailer)", relation, {"trailer": [world.under]}, deck, z)


def empty(world: World) -> World:
    """The world without the mark."""
    objects = tuple(o for o in world.context.objects if o is not world.mark)
    return replace(world, context=replace(world.context, objects=objects))


@pytest.mark.parametrize("level", ["ground", "deck"])
@settings(max_examples=15, deadline=None)
@given(data=st.data())
def test_between_two_things_is_in_the_gap_at_their_level(level, data):
    yaw, gap = data.draw(ANGLES), data.draw(st.floats(2.6, 12.0))
    large = level == "ground" and data.draw(st.booleans())
    size = (6.0, 2.0) if large else (LOAD_M, LOAD_M)
    z = DECK[1] if level == "deck" else 0.0
    if level == "deck":
        gap = data.draw(st.floats(2.6, 4.0))
    ends = rotate(
        np.array([[-(gap + size[0]) / 2, 0.0], [(gap + LOAD_M) / 2, 0.0]]), np.full(2, yaw)
    )
    one = box("one", "drum", (*ends[0], yaw), size, (z, z + HEIGHT_M))
    other = box("other", "crate", (*ends[1], yaw), (LOAD_M, LOAD_M), (z, z + HEIGHT_M))
    trailer = box("trailer", "trailer", (0, 0, yaw), (gap + 3 * LOAD_M, 2.0), DECK)
    start = data.draw(st.sampled_from(STARTS))
    world = with_start(data.draw, start, [one, other, *([trailer] if level == "deck" else [])])

    def right(points):
        local = rotate(points[:, :2], np.full(len(points), -yaw))
        among = (np.abs(local) <= [gap / 2 - HALF_M, 0.8]).all(axis=1)
        return among & (np.abs(points[:, 2] - z) < 0.1) & possible(world, points)

    landmarks = "[OBJ(f = the drum), OBJ(f = the crate)]"
    things = {"drum": [one], "crate": [other]}
    middle = Prism(np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * gap / 2, 0, 1)
    check(world, right, landmarks, "between", things, middle, z)


@st.composite
def row_worlds(draw: st.DrawFn) -> tuple[World, list[PhysicalObject], FloatArray]:
    """A row of crates with any gaps between them, and the direction along it."""
    count, gap, yaw = draw(st.integers(3, 6)), draw(st.floats(1.6, 8.0)), draw(ANGLES)
    places = (np.arange(count) - (count - 1) / 2)[:, None] * gap * np.array([1.0, 0.0])
    turned = rotate(places, np.full(count, yaw))
    own = yaw if draw(st.booleans()) else draw(ANGLES)
    crates = [
        box(f"c{i}", "crate", (*at, own), (LOAD_M, LOAD_M), (0.0, HEIGHT_M))
        for i, at in enumerate(turned)
    ]
    start = draw(st.sampled_from(STARTS))
    away = gap * (count - 1) / 2 + 8.0
    return with_start(draw, start, crates, away), crates, np.array([np.cos(yaw), np.sin(yaw)])


@settings(max_examples=30, deadline=None)
@given(row_worlds())
def test_at_the_end_of_a_row_is_beyond_it_and_in_line(made):
    world, crates, along = made
    reach = max(abs(centre(c.prism) @ along) for c in crates) + HALF_M
    across = np.array([-along[1], along[0]])

    def right(points):
        beyond = np.abs(points[:, :2] @ along) - reach
        in_line = np.abs(points[:, :2] @ across) <= 0.8
        at = (beyond >= HALF_M) & (beyond <= NEAR_M) & (np.abs(points[:, 2]) < 0.1)
        return at & in_line & possible(world, points)

    row_of = "OBJ(f = the row of crates)"
    check(world, right, row_of, "at the end of", {"crate": crates}, crates[-1].prism, 0.0)


@settings(max_examples=30, deadline=None)
@given(row_worlds())
def test_between_the_crates_of_a_row_is_between_two_of_it(made):
    world, crates, along = made
    middles = np.array([centre(c.prism) for c in crates])
    across = np.array([-along[1], along[0]])

    def right(points):
        inside = np.abs(points[:, :2] @ along) < np.abs(middles @ along).max()
        in_line = np.abs(points[:, :2] @ across) <= 0.8
        return inside & in_line & (np.abs(points[:, 2]) < 0.1) & possible(world, points)

    check(world, right, "OBJ(f = the crates)", "between", {"crate": crates}, crates[1].prism, 0.0)


@settings(max_examples=30, deadline=None)
@given(st.data(), st.integers(3, 7), st.floats(4.0, 12.0))
def test_in_the_middle_of_several_things_is_among_them(data, count, gap):
    angle = data.draw(ANGLES) + 2 * np.pi * np.arange(count) / count
    ring = gap * np.column_stack((np.cos(angle), np.sin(angle)))
    crates = [
        box(f"c{i}", "crate", (*at, 0.0), (LOAD_M, LOAD_M), (0.0, HEIGHT_M))
        for i, at in enumerate(ring)
    ]
    start = data.draw(st.sampled_from(STARTS))
    world = with_start(data.draw, start, crates, gap + 8.0)

    def right(points):
        central = np.linalg.norm(points[:, :2], axis=1) <= gap / 3
        return central & (np.abs(points[:, 2]) < 0.1) & possible(world, points)

    middle = Prism(np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]), 0, 1)
    crates_of = "OBJ(f = the crates)"
    check(world, right, crates_of, "in the middle of", {"crate": crates}, middle, 0.0)
