"""Rehearsals: they find before anything moves what physics would stop at."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from corpus_tools.following.plan_execution import run_plan, why_not
from corpus_tools.following.start_states import scenario_start
from corpus_tools.world.physics.rehearsal import rehearse
from corpus_tools.world.scenarios.contexts import scenario_context, scenario_places
from corpus_tools.world.scenarios.scenario_reading import (
    dataset_folder,
    read_scenario,
    scenario_files,
)
from corpus_tools.world.state.robot_script import ScriptStep
from g3.actions.action_kinds import Action
from g3.actions.forklift_actions import PICK_UP
from g3.actions.grounding_candidates import carrier
from g3.actions.robot_state import State, loads_of_context
from g3.groundings import Context
from tests.physics_scenes import on_deck, thing, yard
from tests.worlds import place

SCENARIOS = scenario_files(dataset_folder("warehouse"))


def rehearsed(context: Context, *steps: tuple[str, str | float]) -> str:
    return str(rehearse(context, tuple(ScriptStep(*step) for step in steps)) or "")


def pick_ups(start: State) -> list[str]:
    """Every load that stands on something, and one on the ground: others there are like it."""
    if start.held is not None:
        return []
    loads = [load.id for load in loads_of_context(start.context)]
    high = [load for load in loads if carrier(start, load)]
    return [*high, *[load for load in loads if load not in high][:1]]


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_pick_up_is_carried_out_or_refused_before(name: str) -> None:
    pytest.importorskip("mujoco")
    start = scenario_start(name)
    for load in pick_ups(start):
        actions = [Action(PICK_UP, load)]
        failure = run_plan(start, actions).failure
        assert why_not(start, actions) == str(failure or "")


@pytest.mark.parametrize("name", list(SCENARIOS)[1::5])
def test_scripts_that_were_carried_out_can_be_rehearsed(name: str) -> None:
    scenario = read_scenario(SCENARIOS[name])
    places = scenario_places(scenario)
    assert rehearse(scenario_context(scenario), scenario.script, places=places) is None


def test_a_load_in_the_middle_of_a_deck_is_out_of_reach_and_one_at_its_edge_is_not() -> None:
    truck = thing("wide", "truck", (-3.0, -9.0), 0.0)
    for across, reason in ((0.1, "the forks don't reach so far over wide"), (-0.6, "")):
        crate = thing("crate", "crate", on_deck(truck, -1.0, across), z=1.0)
        why = rehearsed(yard(truck, crate, robot=(2.0, -15.0, 1.5)), ("pick_up", "crate"))
        assert reason in why
        assert bool(why) == bool(reason)


def test_what_a_step_moves_is_where_it_was_put_for_the_steps_after_it() -> None:
    boxed_in = [
        thing("west", "crate", (-8.4, -4.0)),
        thing("east", "crate", (-5.6, -4.0)),
        thing("north", "crate", (-7.0, -2.6)),
        thing("inner", "crate", (-7.0, -4.0)),
        thing("south", "crate", (-7.0, -5.4)),
    ]
    context = yard(*boxed_in, robot=(-7.0, -12.0, 1.57))
    assert "no room to go in and out" in rehearsed(context, ("pick_up", "inner"))
    away = (("pick_up", "south"), ("put_down", "spot"))
    assert rehearsed(context, *away, ("pick_up", "inner")) == ""
    taken = rehearsed(context, *away, ("pick_up", "inner"), ("put_down", "spot"))
    assert taken.startswith("put_down spot: ")


def test_what_the_forks_carry_is_told_before_the_robot_drives() -> None:
    context = yard()
    assert "on the forks already" in rehearsed(context, ("pick_up", "tires"), ("pick_up", "boxes"))
    assert "nothing is on the forks" in rehearsed(context, ("put_down", "spot"))


def test_a_place_in_the_air_is_refused() -> None:
    context = yard()
    high = place("high", (0.5, -5.0), z=1.0)
    script = (ScriptStep("pick_up", "tires"), ScriptStep("put_down", "high"))
    assert "nothing that can be loaded is under high" in str(
        rehearse(context, script, places={"high": high})
    )


def test_rehearsing_needs_no_simulator() -> None:
    program = (
        "import sys; sys.modules['mujoco'] = None\n"
        "from corpus_tools.following.plan_execution import why_not\n"
        "from corpus_tools.following.start_states import scenario_start\n"
        "from g3.actions.action_kinds import Action\n"
        "from g3.actions.forklift_actions import PICK_UP\n"
        "import json\n"
        "start = scenario_start('yard_put_tires_on_truck')\n"
        "print(json.dumps([why_not(start, [Action(PICK_UP, i)]) for i in ('boxes-1', 'tires-1')]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    far, near = json.loads(done.stdout)
    assert "the forks don't reach so far over truck-1" in far
    assert near == ""
