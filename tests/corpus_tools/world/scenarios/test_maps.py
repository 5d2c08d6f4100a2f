from __future__ import annotations

import xml.etree.ElementTree as ET

from corpus_tools.world.scenarios.maps import draw_map
from corpus_tools.world.scenarios.scenario_reading import read_scenario
from tests.corpus_tools.world.scenarios.floor import SCENARIO


def test_a_map_shows_everything_by_its_id(write):
    scenario = read_scenario(write(SCENARIO.replace("The forklift puts", "<Tires> & more are put")))
    svg = ET.fromstring(draw_map(scenario))
    texts = [item.text for item in svg.iter("{http://www.w3.org/2000/svg}text")]
    for name in (*scenario.all_objects, *scenario.all_places, "forklift"):
        assert name in texts
    assert texts[-2:] == ["1. pick_up tires-1", "2. put_down on-trailer-1"]


def test_left_in_the_layout_is_left_in_the_map(write):
    svg = ET.fromstring(draw_map(read_scenario(write())))
    at = {
        item.text: (float(item.get("x")), float(item.get("y")))
        for item in svg.iter("{http://www.w3.org/2000/svg}text")
    }
    assert at["corner"][0] < at["boxes-2"][0] < at["receiving"][0]
    assert at["corner"][1] > at["boxes-2"][1] > at["tires-1"][1] > at["shelf-a"][1]
