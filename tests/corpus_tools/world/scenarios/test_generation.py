"""Generated scenarios: possible, as various as promised, and always the same."""

from __future__ import annotations

import functools

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from corpus_tools.runtime.shipped import bundled
from corpus_tools.world.scenarios.boxes import start_boxes
from corpus_tools.world.scenarios.contexts import scenario_context
from corpus_tools.world.scenarios.random_scenarios import TASKS, generate
from corpus_tools.world.scenarios.scenario import ROBOT, Bounds, Layout
from corpus_tools.world.scenarios.scenario_files import format_scenario
from corpus_tools.world.scenarios.scenario_reading import all_errors, read_layouts, read_scenario
from g3.errors import FormatError

DATASET = bundled()["warehouse"]


@functools.cache
def layouts():
    return read_layouts(DATASET)


@functools.cache
def one_of_each_task():
    return [generate(3, number, layouts()) for number in range(len(TASKS))]


some = settings(max_examples=12)
seeds = st.integers(0, 2**32)
numbers = st.integers(0, 10_000)


@some
@given(seed=seeds, number=numbers)
def test_nothing_is_in_anything_else_or_outside(seed, number):
    scenario = generate(seed, number, layouts())
    bounds = scenario.layout.bounds
    floor = shapely.box(bounds.x[0], bounds.y[0], bounds.x[1], bounds.y[1]).buffer(1e-6)
    boxes = start_boxes(scenario.all_objects, scenario.robot)
    shapes = {name: shapely.Polygon(box.footprint) for name, box in boxes.items()}
    for name, shape in shapes.items():
        assert floor.contains(shape)
        for other, around in shapes.items():
            level = (
                boxes[name].z_min < boxes[other].z_max and boxes[other].z_min < boxes[name].z_max
            )
            if name < other and level and {name, other} != {ROBOT, scenario.robot.carries}:
                assert shape.intersection(around).area < 1e-3, (name, other)


@some
@given(seed=seeds, number=numbers)
def test_what_is_written_is_read_again(seed, number, tmp_path_factory):
    scenario = generate(seed, number, layouts())
    file = tmp_path_factory.getbasetemp() / f"{scenario.id}.yaml"
    file.write_text(format_scenario(scenario))
    assert all_errors(file) == []
    assert read_scenario(file) == scenario
    assert len(scenario_context(scenario).objects) == len(scenario.all_objects) + 1


def test_the_same_seed_gives_the_same_scenarios():
    once, again = (format_scenario(generate(5, 7, layouts())) for _ in range(2))
    assert once == again
    assert once != format_scenario(generate(6, 7, layouts()))


def test_scenarios_in_a_row_cover_all_tasks():
    made = one_of_each_task()
    actions = {step.action for scenario in made for step in scenario.script}
    assert actions == {"drive_to", "drive_past", "approach", "pick_up", "put_down"}
    titles = " ".join(scenario.title for scenario in made)
    for words in ("which carries", "a loaded truck", "on a trailer", "from a truck", "storage",
                  "beside", "past"):  # fmt: skip
        assert words in titles
    assert len({scenario.layout.name for scenario in made}) > 3


def test_loads_are_entered_from_where_there_is_room():
    for scenario in one_of_each_task():
        boxes = start_boxes(scenario.all_objects, scenario.robot)
        for step in scenario.script:
            if step.action != "pick_up":
                continue
            load = boxes[str(step.argument)]
            back = np.array([np.cos(load.pose[2]), np.sin(load.pose[2])])
            lane = shapely.LineString([load.middle - 0.6 * back, load.middle - 4 * back])
            thing = scenario.all_objects[str(step.argument)]
            in_the_way = [
                name
                for name, box in boxes.items()
                if name not in (thing.deck, step.argument)
                and lane.buffer(0.6, cap_style="flat").intersects(shapely.Polygon(box.footprint))
            ]
            assert in_the_way in ([], [ROBOT]), scenario.title


def test_a_layout_without_room_is_told():
    tiny = Layout("tiny", "A cupboard.", (0, 0), 0, Bounds((0, 3), (0, 3)), {}, {})
    with pytest.raises(FormatError, match="no room"):
        generate(0, 0, {"tiny": tiny})


def test_layouts_without_areas_get_some():
    empty = Layout("empty", "A field.", (0, 0), 0, Bounds((-20, 20), (-20, 20)), {}, {})
    storing = generate(1, 8, {"empty": empty})
    assert storing.title.endswith("to storage.")
    assert [*storing.places] == ["storage-1"]
