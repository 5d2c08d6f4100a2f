"""Colours, sizes and what is on things tell apart what is called the same."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from g3.actions.robot_state import start_state
from g3.groundings import Colour, Context, PhysicalObject
from g3.inference.grounder import Grounder
from g3.inference.potentials.cases import FactorCase
from g3.inference.problem.grounding_problem import GroundingProblem
from g3.inference.problem.packed_scene import scene_of
from g3.language.lexicon.attribute_words import colours_named, sizes_named
from g3.language.lexicon.tables import members
from g3.sdc.sdc_notation import parse_brackets
from tests.g3.actions.yards import box, forklift
from tests.g3.inference.constant_cost import ConstantCost
from tests.g3.inference.ruled import WEIGHT, adds, of_things, tree_of
from tests.worlds import thing

COLOURS = get_args(Colour)
LIFT = "EVENT(r = Pick up, l = {})"
TALL, SHORT = ("height", 1), ("height", -1)


def painted(own: PhysicalObject, *colours: Colour) -> PhysicalObject:
    return replace(own, colours=colours)


@st.composite
def places(draw: st.DrawFn, count: int) -> list[tuple[float, float, float]]:
    """Poses of loads that stand about the robot with room between them."""
    angles = draw(st.permutations(range(2 * count)))[:count]
    turn = draw(st.floats(-3.1, 3.1))
    return [
        (
            (away := draw(st.floats(6.0, 20.0))) * np.cos(turn + np.pi * i / count),
            away * np.sin(turn + np.pi * i / count),
            draw(st.floats(-3.1, 3.1)),
        )
        for i in angles
    ]


def picked(context: Context, notation: str) -> str | None:
    """What is lifted by a cost that knows nothing, so that only rules tell things apart."""
    clauses = parse_brackets(LIFT.format(notation))
    plan = Grounder(ConstantCost()).follow(clauses, context, least=0.0).plan
    return None if plan is None else plan.state.held


def world(*things: PhysicalObject) -> Context:
    return Context("world", (*things, forklift()), (), "agent")


SAID = (
    "OBJ(f = the {} crate)",
    "OBJ(f = the {} one)",
    "OBJ(f = OBJ(f = the crate), r = that is {})",
)


@settings(max_examples=40, deadline=None)
@given(
    poses=places(3),
    colours=st.permutations(COLOURS).map(lambda all_: all_[:3]),
    meant=st.integers(0, 2),
    said=st.sampled_from(SAID),
    data=st.data(),
)
def test_of_things_alike_the_one_in_the_colour_is_meant(poses, colours, meant, said, data):
    crates = [
        painted(box(f"c{i}", "crate", pose), colour)
        for i, (pose, colour) in enumerate(zip(poses, colours, strict=True))
    ]
    if data.draw(st.booleans()):  # of another thing nobody has said
        crates[meant - 1] = painted(crates[meant - 1])
    word = data.draw(st.sampled_from(members("colour")[colours[meant]].words.split()))
    assert picked(world(*crates), said.format(word)) == f"c{meant}"


@settings(max_examples=60, deadline=None)
@given(
    poses=places(3),
    sense=st.sampled_from(list(members("size"))),
    meant=st.integers(0, 2),
    factor=st.floats(1.2, 1.5),
    said=st.sampled_from(SAID),
    data=st.data(),
)
def test_of_things_alike_the_tall_or_the_small_one_is_meant(
    poses, sense, meant, factor, said, data
):
    dimension = sense.removeprefix("-")
    scale = factor if dimension == sense else 1 / factor
    sides = [(1.6, 1.0, 0.8)] * 3
    sides[meant] = tuple(
        side * (scale if dimension in (own, "volume") else 1.0)
        for own, side in zip(("length", "width", "height"), sides[0], strict=True)
    )
    crates = [
        box(f"c{i}", "crate", pose, (length, width), (0.0, height))
        for i, (pose, (length, width, height)) in enumerate(zip(poses, sides, strict=True))
    ]
    word = data.draw(st.sampled_from(members("size")[sense].words.split()))
    assert picked(world(*crates), said.format(word)) == f"c{meant}"


@settings(max_examples=12, deadline=None)
@given(
    poses=places(3),
    word=st.sampled_from([w for row in members("colour").values() for w in row.words.split()]),
    said=st.sampled_from(SAID),
)
def test_where_no_colour_is_known_words_for_colours_cost_nothing(poses, word, said):
    crates = [box(f"c{i}", "crate", pose) for i, pose in enumerate(poses)]
    clauses = parse_brackets(LIFT.format(said.format(word)))
    plans = [
        Grounder(ConstantCost(), without=off).follow(clauses, world(*crates), least=0.0, top=20)
        for off in ((), ("colour",))
    ]
    with_rule, without = ([(p.actions, p.probability) for p in r.plans] for r in plans)
    assert len(with_rule) > 1
    assert with_rule == without


CRATES = [
    painted(thing("red", "crate", 5, 0), "red"),
    painted(thing("blue", "crate", 8, 0), "blue"),
    thing("unsaid", "crate", 3, 0, z=(0, 2)),
    thing("pallet", "pallet", 3, 5),
]


def test_other_colours_are_wrong_and_unknown_ones_where_another_has_the_colour():
    dear = WEIGHT["colour"]
    of_red = of_things("colour", CRATES, "OBJ(f = the red crate)")
    assert of_red.tolist() == [0, dear, dear, 0]
    # Where none has the colour, what nobody has said may have it.
    of_green = of_things("colour", CRATES, "OBJ(f = the green crate)")
    assert of_green.tolist() == [dear, dear, 0, 0]
    both = of_things("colour", CRATES, "OBJ(f = the red or navy crate)")
    assert both.tolist() == [0, 0, dear, 0]


def test_what_is_tall_is_so_among_things_of_its_colour():
    boxes = [
        painted(thing(name, "box", x, 0, z=(0, high)), colour)
        for name, x, high, colour in (
            ("low", 3, 1.0, "red"),
            ("high", 6, 1.5, "red"),
            ("other", 9, 2.0, "blue"),
        )
    ]
    wrong = WEIGHT["size"]
    assert of_things("size", boxes, "OBJ(f = the tall box)").tolist() == [wrong, wrong, 0]
    red = of_things("size", boxes, "OBJ(f = the tall red box)")
    assert red[:2].tolist() == [wrong, 0]


def test_sizes_count_where_people_see_that_they_differ():
    boxes = [thing(n, "box", x, 0, z=(0, z)) for n, x, z in (("a", 3, 1.0), ("b", 6, 1.04))]
    assert not of_things("size", boxes, "OBJ(f = the tall box)").any()
    # A label of its own: the truck doesn't make the box short.
    mixed = [*boxes, thing("truck", "truck", 9, 0, z=(0, 3))]
    assert not of_things("size", mixed, "OBJ(f = the tall box)").any()


@pytest.mark.parametrize(
    ("said", "right"), [("tall", {"c", "d"}), ("short", {"a", "b"}), ("tallest", {"c", "d"})]
)
def test_a_plural_means_all_that_are_tall(said, right):
    crates = [
        box(name, "crate", (8.0, 2.5 * i, 0.0), z=(0.0, 0.7 if name in "ab" else 1.4))
        for i, name in enumerate("abcd")
    ]
    state = start_state(world(*crates))
    groups = [tuple(c for c in crates if c.id in ids) for ids in ("ab", "cd", "abcd", "ac")]
    assert [ids for ids in groups if _fits(state, groups, ids, said)] == [
        tuple(c for c in crates if c.id in right)
    ]


def _fits(state, groups, group, said) -> bool:
    problem = GroundingProblem(state, scene_of(state.context, groups), ConstantCost())
    tree = tree_of(f"OBJ(f = the {said} crates)")
    index = len(state.context.objects) + groups.index(group)
    batch = problem.scene.batch(
        "OBJECT", [tree.words[0]], np.zeros(1, dtype=np.intp), figure=np.array([index])
    )
    return not adds("size", FactorCase(tree, 0, batch, problem, [len(group)])).any()


def test_sizes_that_are_assumed_count_for_nothing():
    low, high = (
        box(name, "crate", (8.0, y, 0.0), z=(0.0, z))
        for name, y, z in (("a", 3, 0.7), ("b", -3, 1.4))
    )
    context, groups = world(low, high), [(low,), (high,)]
    assert not _fits(start_state(context), groups, groups[0], "tall")
    assumed = replace(context, assumed=(("b", "size"),))
    assert _fits(start_state(assumed), groups, groups[0], "tall")


def deck(name: str, x: float) -> PhysicalObject:
    return box(name, "trailer", (x, 8.0, 0.0), (5.0, 2.0), (0.4, 0.85))


def on_deck(name: str, labels: str, x: float) -> PhysicalObject:
    return box(name, labels, (x, 8.0, 0.0), z=(0.85, 1.5))


DECKS = (deck("laden", 0.0), deck("bare", 9.0), on_deck("tires", "tire pallet", 0.0))


@pytest.mark.parametrize(
    ("notation", "wrong"),
    [
        ("OBJ(f = the empty trailer)", [True, False]),
        ("OBJ(f = the loaded trailer)", [False, True]),
        ("OBJ(f = OBJ(f = the trailer), r = that is empty)", [True, False]),
        (
            "OBJ(f = OBJ(f = the trailer), r = with, "
            "l = OBJ(f = OBJ(f = nothing), r = on, l = OBJ(f = it)))",
            [True, False],
        ),
        ("OBJ(f = the empty side of the trailer)", [False, False]),
        ("OBJ(f = the trailer)", [False, False]),
    ],
)
def test_what_is_on_a_thing_tells_it_from_others(notation, wrong):
    found = of_things("contents", DECKS, notation)
    assert found[:2].tolist() == [WEIGHT["contents"] * own for own in wrong]


def test_a_trailer_with_the_tires_has_them_on_it():
    with_tires = "OBJ(f = OBJ(f = the trailer), r = with, l = OBJ(f = the tires))"
    found = of_things("carries", DECKS, with_tires, landmark=(DECKS[2],))
    assert found[:2].tolist() == [0, WEIGHT["carries"]]
    beside = "OBJ(f = OBJ(f = the trailer), r = near, l = OBJ(f = the tires))"
    assert not of_things("carries", DECKS, beside, landmark=(DECKS[2],)).any()


def test_words_of_colours_and_sizes():
    assert colours_named(["a", "gray", "and", "crimson", "crate"]) == {"grey", "red"}
    assert sizes_named(["the", "tallest", "tiny", "thing"]) == [(TALL,), (("volume", -1),)]
    assert sizes_named(["short"]) == [(SHORT, ("length", -1))]
    assert set(members("colour")) == set(COLOURS)


def test_a_trained_model_takes_the_one_in_the_colour(grounder):
    crates = [
        painted(box("left", "crate", (8.0, 2.0, 0.0)), "blue"),
        painted(box("right", "crate", (8.0, -2.0, 0.0)), "red"),
        painted(box("boxes", "box pallet", (12.0, 0.0, 0.0)), "red"),
    ]
    for text, meant in (
        ("Pick up the red crate.", "right"),
        ("Lift the blue one", "left"),
        ("get the red boxes", "boxes"),
    ):
        plan = grounder.follow(text, world(*crates), least=0.0).plan
        assert plan is not None
        assert plan.state.held == meant, text
