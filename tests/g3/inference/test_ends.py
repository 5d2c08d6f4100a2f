"""Where a command's words, without trees, say that things end."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from g3.actions.action_kinds import Action
from g3.actions.forklift_actions import CARRY, DRIVE_TO, PICK_UP
from g3.actions.robot_state import moved_to, start_state, with_moved
from g3.errors import ModelError
from g3.inference.ends.described import describe
from g3.inference.ends.end_model import (
    AHEAD,
    AROUND,
    BACK,
    ELSEWHERE,
    GROUND,
    HELD,
    LEAST,
    LEFT,
    NEAR,
    ON,
    RIGHT,
    SIDES,
    STANDS,
    STAYS,
    EndModel,
    Ends,
    JointEnds,
    default_end_model,
    end_evidence,
    ends_of,
    known_ends,
    load_ends,
    robot_ends,
)
from g3.language.parsing.sdc_parser import default_parser
from g3.language.parsing.words import cut
from tests.g3.inference.following_commands import TIRES, YARD, world

START = start_state(world(**YARD))
IDS = [o.id for o in START.context.objects if o.id != START.context.agent_id]


def put(name, x, y, bottom=0.0, before=START):
    moved = moved_to(before.thing(name), np.array([x, y, 0.0]), bottom)
    return with_moved(before, {name: moved}, None)


def on_truck(name, truck, before=START, ahead=0.0):
    deck = before.thing(truck).prism
    x, y = deck.xy.mean(axis=0)
    return put(name, x + ahead, y, bottom=deck.z_max, before=before)


def at(x, y, yaw=0.0):
    robot = START.context.agent_id
    return with_moved(
        START, {robot: moved_to(START.thing(robot), np.array([x, y, yaw]), 0.0)}, None
    )


def seen(text, state=START):
    return describe(cut(text), state, default_parser().encoder_)


def test_a_thing_is_described_by_where_it_is_among_those_alike():
    found = seen("lift it").features[:, 5:14].reshape(-1, 3, 3)
    of = dict(zip(IDS, found, strict=True))
    # each of distance, ahead and left: its rank from 0 to 1, and whether it is first or last
    assert of["tires-1"].tolist() == [[0, 1, 0], [0, 1, 0], [1, 0, 1]]
    assert of["tires-2"].tolist() == [[1, 0, 1], [1, 0, 1], [0, 1, 0]]
    assert of["cone-1"].tolist() == [[0.5, 1, 1]] * 3


def test_what_stands_on_what_is_described():
    truck = {"truck_1": ("truck", (10, 0)), "tires_1": (TIRES, (10, 0), 0, "truck-1")}
    state = start_state(world(**truck))
    pairs = seen("lift them", state).pairs
    ids = [o.id for o in state.context.objects if o.id != state.context.agent_id]
    truck_row, tires_row = ids.index("truck-1"), ids.index("tires-1")
    assert pairs[tires_row, truck_row, :3].tolist() == [1, 0, 0]
    assert pairs[truck_row, tires_row, :3].tolist() == [0, 1, 0]


@settings(max_examples=10, deadline=None)
@given(order=st.permutations(range(len(YARD))))
def test_the_order_of_things_makes_no_difference(order):
    own = START.context
    robot = own.agent
    things = [o for o in own.objects if o.id != own.agent_id]
    shuffled = replace(START, context=replace(own, objects=(*(things[i] for i in order), robot)))
    first = ends_of("both crates on the left truck", START).given({})
    second = ends_of("both crates on the left truck", shuffled).given({})
    for own in (slice(NEAR), slice(NEAR, NEAR + len(order)), slice(NEAR + len(order), None)):
        moved = order if own.start else slice(None)
        np.testing.assert_allclose(second.robot[own], first.robot[own][moved], atol=1e-4)
    for new, old in enumerate(order):
        one, other = first.loads[old], second.loads[new]
        np.testing.assert_allclose(other[:ON], one[:ON], atol=1e-4)
        np.testing.assert_allclose(
            other[ON:][: len(order)], one[ON:][: len(order)][order], atol=1e-4
        )


def test_probabilities_of_ends_sum_to_one():
    joint = ends_of("Put the crates on the truck.", START)
    assert [IDS[row] for row in joint.rows] == ["tires-1", "tires-2", "crate-1", "crate-2"]
    for told in ({}, {joint.rows[0]: STAYS}, {joint.rows[3]: ON + IDS.index("truck-1")}):
        found = joint.given(told)
        for odds in (found.loads, found.sides, found.robot[None]):
            np.testing.assert_allclose(np.exp(odds).sum(axis=1), 1, atol=1e-5)


def one_of_two(told):
    """Two loads, of which one is lifted: which one is even, and the other one stays."""
    held = {0: 0.5, 1: 0.5} | {1 - row: float(end == STAYS) for row, end in told.items()}
    loads = np.full((2, ON + 4), 1e-12)
    loads[:, HELD], loads[:, STAYS] = [held[0], held[1]], [1 - held[0], 1 - held[1]]
    robot, sides = np.full(NEAR + 4, 1 / (NEAR + 4)), np.full((2, len(SIDES)), 1 / len(SIDES))
    return Ends(*(np.log(odds + 1e-12) for odds in (loads, robot, sides)))


@pytest.mark.parametrize(
    ("ends", "chance"), [((HELD, STAYS), 0.5), ((STAYS, HELD), 0.5), ((STAYS, STAYS), 0)]
)
def test_ends_of_several_loads_are_probable_together(ends, chance):
    joint = JointEnds([0, 1], one_of_two)
    told = joint.log_probability({row: (end,) for row, end in enumerate(ends)})
    np.testing.assert_allclose(np.exp(told), chance, atol=1e-6)


def test_a_known_end_is_a_type_and_a_link():
    decided, links = known_ends({0: HELD, 1: ON + 2, 2: ON + 3 + 0}, 3)
    assert decided.argmax(axis=1).tolist() == [HELD, ON, ON + 1]
    assert np.argwhere(links[..., 0]).tolist() == [[1, 2], [2, 0]]
    np.testing.assert_array_equal(links[..., 1], links[..., 0].T)


def test_no_words_and_no_things_say_nothing():
    assert ends_of("", START) is None
    assert ends_of("go", start_state(world())) is None


def test_a_load_ends_where_it_was_put():
    row, count = IDS.index("crate-1"), len(IDS)
    assert load_ends(row, on_truck("crate-1", "truck-1"), START) == [ON + IDS.index("truck-1")]
    lifted = replace(START, held="crate-1")
    assert load_ends(row, lifted, START) == [HELD]
    assert load_ends(row, lifted, lifted) == [STAYS]
    beside_cone = load_ends(row, put("crate-1", 16, 2), START)
    near = [IDS[end - ON - count] for end in beside_cone[1:]]
    assert beside_cone[0] == GROUND
    assert near == ["tires-2", "cone-1"]  # tires-2 at 4.1 m, cone-1 at 3 m; all others at 8 or more


@pytest.mark.parametrize(
    ("pose", "ends"),
    [
        ((0, 0, 0), [STANDS]),
        ((1, 0.5, np.pi / 12), [STANDS]),
        ((0, 0, np.pi / 2), [LEFT]),
        ((0, 0, -np.pi / 2), [RIGHT]),
        ((0, 0, 3.1), [AROUND]),
        ((3, 0.5, 0), [AHEAD]),
        ((-4, 0, 0), [BACK]),
        ((0, -30, 0), [ELSEWHERE]),
    ],
)
def test_the_robot_ends_where_it_stands_and_looks(pose, ends):
    state = start_state(world(cone_1=("cone", (20, -20)), truck_1=("truck", (25, 20))))
    assert robot_ends(np.array(pose, dtype=float), state) == ends


def test_the_robot_ends_near_things_and_faces_them():
    state = start_state(world(cone_1=("cone", (20, -20)), truck_1=("truck", (25, 20))))
    near_cone, facing_cone = NEAR, NEAR + 2
    assert robot_ends(np.array([17, -17, 1.0]), state) == [near_cone]
    assert robot_ends(np.array([0, 0, -np.pi / 4]), state) == [facing_cone]
    # the border of the cone is 5.8 m away, straight on
    straight = start_state(world(cone_1=("cone", (10, 0))))
    assert robot_ends(np.array([4, 0, 0.0]), straight) == [AHEAD, near_cone]


@pytest.mark.parametrize(
    ("text", "right", "wrong"),
    [
        ("Stick both crates up on the left truck, mate", "truck-1", "truck-2"),
        ("The truck on the right gets the crates, all of them.", "truck-2", "truck-1"),
    ],
)
def test_the_end_that_words_say_is_more_probable(text, right, wrong):
    told = ends_of(text, START)
    actions = (Action(CARRY, "crate-1"), Action(CARRY, "crate-2"))
    plans = {}
    for truck in (right, wrong):
        end = on_truck("crate-2", truck, on_truck("crate-1", truck), ahead=1.5)
        plans[truck] = end_evidence(told, actions, end, START)
    half = end_evidence(told, (Action(CARRY, "crate-1"),), on_truck("crate-1", right), START)
    idle = end_evidence(told, (Action(DRIVE_TO),), at(8, 2), START)
    assert plans[right] > max(plans[wrong], half, idle)


def test_what_is_quite_improbable_is_no_worse_than_the_least():
    told = ends_of("Stay where you are and touch nothing!", START)
    everything = tuple(Action(PICK_UP, name) for name in IDS[:4])
    end = START
    for name in IDS[:4]:
        end = on_truck(name, "truck-1", end)
    assert end_evidence(told, everything, end, START) == LEAST


def test_a_damaged_file_is_named():
    content = bytearray(default_end_model().to_bytes())
    content[len(content) // 2] ^= 0xFF
    with pytest.raises(ModelError, match=r"mine\.npz"):
        EndModel.from_bytes(bytes(content), where="mine.npz")


def test_a_file_holds_the_model():
    model = default_end_model()
    again = EndModel.from_bytes(model.to_bytes())
    described = seen("crates on the truck")
    assert np.array_equal(again.ends(described).loads, model.ends(described).loads)
