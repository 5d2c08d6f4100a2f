from __future__ import annotations

import importlib

import numpy as np
import pytest

from corpus_tools.world.scenarios.boxes import FORK_HEEL_M, FORKS_M, FORKS_TOP_M
from corpus_tools.world.scenarios.contexts import scenario_context, scenario_places
from corpus_tools.world.scenarios.scenario_reading import read_scenario
from corpus_tools.world.state.thing_kinds import FORKLIFT
from g3.actions.logged_actions import loaded
from tests.corpus_tools.world.scenarios.floor import SCENARIO

CARRYING = SCENARIO.replace("at: [7, 1.5]", "yaw_deg: 90").replace(
    "robot: {at: [0, 0]}", "robot: {at: [2, 3], yaw_deg: 90, carries: tires-1}"
).replace("  - pick_up: tires-1\n", "")  # fmt: skip


@pytest.fixture
def context(write):
    return scenario_context(read_scenario(write()))


def find(context, name):
    return next(item for item in context.objects if item.id == name)


def test_the_layout_moves_and_turns_everything(context):
    tires = find(context, "tires-1")
    assert tires.trajectory.xyz[0] == pytest.approx([10 - 1.5, 20 + 7, 0.35])
    assert tires.trajectory.yaw[0] == pytest.approx(np.pi / 2)
    assert tires.prism.xy[0] == pytest.approx([8.5 + 0.6, 27 - 0.5])
    assert (tires.prism.z_min, tires.prism.z_max) == (0, 0.7)


def test_loads_and_places_are_on_the_decks(context):
    boxes = find(context, "boxes-1")
    assert boxes.prism.z_min == 0.85
    assert boxes.trajectory.xyz[0, 2] == pytest.approx(0.85 + 1.05 / 2)
    assert find(context, "trailer-1").prism.z_min == 0.45
    assert context.places[0].prism.z_min == 0.85


def test_the_robot_is_between_its_front_wheels(context):
    robot = context.agent
    assert robot.labels == ("forklift",)
    assert robot.trajectory.xyz[0] == pytest.approx([10, 20, 0])
    middle = robot.prism.xy.mean(axis=0)
    assert middle == pytest.approx([10, 20 + FORKLIFT.ahead_m])


def test_things_have_the_colours_that_they_are_painted(write):
    text = SCENARIO.replace("at: [7, -3]", "at: [7, -3], colours: [white, blue]")
    objects = scenario_context(read_scenario(write(text))).objects
    colours = {o.id: o.colours for o in objects if o.colours}
    assert colours == {"boxes-2": ("white", "blue")}


def test_places_have_the_names_of_the_map(write):
    scenario = read_scenario(write())
    places = scenario_places(scenario)
    assert {name: place.name for name, place in places.items()} == {
        "on-trailer-1": "", "corner": "", "receiving": "receiving"
    }  # fmt: skip
    assert tuple(places.values()) == scenario_context(scenario).places


def test_what_is_carried_is_on_the_forks(write):
    context = scenario_context(read_scenario(write(CARRYING)))
    tires = find(context, "tires-1")
    ahead = FORK_HEEL_M + 0.6  # it lies across
    assert tires.trajectory.xyz[0, :2] == pytest.approx([10 - 3 - ahead, 20 + 2])
    assert tires.trajectory.yaw[0] == pytest.approx(1.5 * np.pi)
    assert tires.prism.z_min > 0.1
    assert loaded(context) == "tires-1"


def test_the_forks_are_where_the_simulator_has_them():
    pytest.importorskip("mujoco")
    sizes = importlib.import_module("corpus_tools.world.state.dimensions")
    start = importlib.import_module("corpus_tools.world.state.start")
    assert pytest.approx(sizes.HEEL_X + start.HEEL_GAP_M) == FORK_HEEL_M
    assert (
        pytest.approx((sizes.FORK_LENGTH, 2 * sizes.FORK_Y + sizes.FORK_WIDTH), abs=0.03) == FORKS_M
    )
    assert pytest.approx(sizes.LOW) == FORKS_TOP_M
