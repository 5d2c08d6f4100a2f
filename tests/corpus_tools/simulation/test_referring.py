"""What simulated workers call things is true of the thing that they mean."""

from __future__ import annotations

from collections import Counter

import numpy as np

from corpus_tools.runtime.shipped import bundled
from corpus_tools.simulation.grammar import Wording, refer, see
from corpus_tools.world.scenarios.random_scenarios import generate
from corpus_tools.world.scenarios.scenario_reading import read_layouts
from g3.language.lexicon.attribute_words import colours_named, sizes_named

LAYOUTS = read_layouts(bundled()["warehouse"])


def test_things_are_called_by_their_colours_and_heights():
    rng = np.random.default_rng(1)
    said: Counter[str] = Counter()
    for number in range(24):
        scene = see(generate(2, number, LAYOUTS))
        for thing in scene.things.values():
            wording = Wording()
            refer(wording, scene, thing, rng, vague=False)
            words = wording.text.split()
            if colours := colours_named(words):
                said["colour"] += 1
                assert colours <= set(thing.colours), wording.text
            for (_, pole), *_ in sizes_named(words):
                said["size"] += 1
                heights = [t.height for t in scene.things.values() if t.labels & thing.labels]
                edge = max(heights) if pole > 0 else min(heights)
                assert thing.height == edge, wording.text
    assert min(said["colour"], said["size"]) >= 2, said
