from __future__ import annotations

import pytest

from tests.examples.installed import EXAMPLES, install

BUILD = """
import pathlib, sys
from corpus_tools.world.physics.build import build_world
from corpus_tools.world.looks.look_registry import look_of, plain
from corpus_tools.world.scenarios.contexts import scenario_context
from corpus_tools.world.scenarios.scenario_reading import read_scenario
context = scenario_context(read_scenario(pathlib.Path(sys.argv[1])))
world = build_world(context)
lifted = [o.id for o in context.objects].index("reel-1") in world.free
print(lifted, look_of("cable-reel") is not plain)
"""
SCENARIO = str(EXAMPLES / "cable_reel/scenarios/dock_take_reel_to_truck.yaml")


@pytest.fixture(scope="module")
def reel(tmp_path_factory):
    return install("cable_reel", tmp_path_factory.mktemp("reel"))


def test_scenarios_may_hold_its_kind(reel):
    kinds = reel.ct("scenarios", "kinds").stdout.splitlines()
    assert any(line.split()[:6] == ["cable-reel", "cable", "reel", "1", "x", "1"] for line in kinds)
    assert reel.ct("scenarios", "check", SCENARIO).stdout == "1 scenario: no problems\n"


def test_physics_and_pictures_know_it(reel):
    done = reel.python(BUILD, SCENARIO)
    assert done.stdout.split() == ["True", "True"], done.stderr
