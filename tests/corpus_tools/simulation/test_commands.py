"""What simulated workers type."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from corpus_tools.simulation.dataset import commands_for, format_commands
from corpus_tools.simulation.grammar import Worker, draw_workers, misspell, see, tell
from corpus_tools.world.scenarios.random_scenarios import generate
from corpus_tools.world.scenarios.scenario import Bounds, Layout, Region, Robot, Scenario, Thing
from corpus_tools.world.scenarios.scenario_reading import dataset_folder, read_layouts
from corpus_tools.world.state.robot_script import ScriptStep
from g3.errors import CorpusError
from g3.sdc.clauses import breadth_first
from g3.sdc.sdc_notation import check_sdc, format_brackets, parse_brackets

LAYOUTS = read_layouts(dataset_folder("warehouse"))
EXACT = Worker("simulated-0000", 0.0, 0.0, 0.0, capitals=True, full_stop=True)
FLOOR = Layout("floor", "A floor", (0.0, 0.0), 0.0, Bounds((-20, 20), (-20, 20)), {}, {})


def scenario(objects, script, places=None):
    return Scenario("row", "A row.", FLOOR, objects, places or {}, Robot((0, 0)), script)


def row():
    """Three pallets of tires in a row before the robot, from its right to its left."""
    return {
        f"tires-{number}": Thing("tire-pallet", (8.0, y))
        for number, y in ((1, -4.0), (2, 0.0), (3, 4.0))
    }


def texts(made, count=1500, worker=EXACT):
    scene = see(made)
    return {
        told.wording.text: told
        for told in (tell(scene, worker, np.random.default_rng(seed)) for seed in range(count))
    }


def test_a_thing_is_told_from_its_like():
    left = texts(scenario(row(), (ScriptStep("pick_up", "tires-3"),)))
    assert "Lift the leftmost tire pallet." in left
    assert "Pick up the first skid from the left." in left
    told = left["Get the pallet of tires on the left."]
    assert format_brackets(told.sdcs) == (
        "EVENT_1(r = Get, l = OBJ_2(f = OBJ_3(f = OBJ_4(f = the pallet), r = of, "
        "l = OBJ_5(f = tires)), r = on the left))"
    )
    assert not any("right" in text.replace("from the right", "") for text in left)

    middle = texts(scenario(row(), (ScriptStep("pick_up", "tires-2"),)))
    assert "Grab the second tires from the right." in middle
    assert not any("leftmost" in text or "on the right" in text for text in middle)


def test_a_lone_thing_needs_nothing_else():
    alone = {"tires-1": Thing("tire-pallet", (8.0, 0.0)), "truck-1": Thing("truck", (0.0, 9.0))}
    said = texts(scenario(alone, (ScriptStep("pick_up", "tires-1"),)))
    assert not any(word in text for text in said for word in ("left", "nearest", "next to"))


def test_vague_workers_leave_out_what_would_tell():
    vague = Worker("simulated-0001", 0.0, 1.0, 0.0, capitals=False, full_stop=False)
    said = texts(scenario(row(), (ScriptStep("pick_up", "tires-3"),)), worker=vague)
    assert "lift the pallet" in said
    assert not any("left" in text for text in said)


def test_particles_stand_apart_and_pronouns_before_them():
    places = {"storage": Region((14.0, 0.0), (4.0, 4.0), name="storage A")}
    script = (ScriptStep("pick_up", "tires-1"), ScriptStep("put_down", "storage"))
    objects = {"tires-1": Thing("tire-pallet", (8.0, 0.0))}
    said = texts(scenario(objects, script, places), 6000)
    told = said["Pick the tires up and set it down in storage A."]
    assert format_brackets(told.sdcs) == (
        "EVENT_1(r = Pick up, l = OBJ_2(f = the tires))\n"
        "EVENT_3(r = set down, l = OBJ_4(f = it), l2 = PLACE_5(r = in, l = OBJ_6(f = storage A)))"
    )
    place = told.sdcs[1].landmark2[0]
    assert told.wording.grounding(place) == ("storage",)
    assert told.wording.grounding(told.sdcs[1].landmark1[0]) == ("tires-1",)
    assert not any("up it" in text or "down it" in text for text in said)


@settings(max_examples=20, deadline=None)
@given(number=st.integers(0, 400), seed=st.integers(0, 1000))
def test_trees_are_well_formed_and_stand_in_the_text(number, seed):
    made = generate(number, number, LAYOUTS)
    workers = draw_workers(5, seed)
    for _, told in commands_for(made, workers, 3, seed):
        text = told.wording.text
        for sdc in told.sdcs:
            check_sdc(sdc)
        assert parse_brackets(format_brackets(told.sdcs), command=text) is not None
        for node in breadth_first(told.sdcs):
            for span in (*node.words, *node.relation):
                assert text[span.start : span.end] == span.text
            if node.type in ("PLACE",) or (node.type == "OBJECT" and node.words):
                assert told.wording.grounding(node)


def test_the_same_seed_gives_the_same_commands():
    made = generate(3, 6, LAYOUTS)
    workers = draw_workers(10, 3)
    first, again = (format_commands(commands_for(made, workers, 8, 3)) for _ in range(2))
    assert first == again
    assert first != format_commands(commands_for(made, workers, 8, 4))
    assert len({worker.id for worker, _ in commands_for(made, workers, 8, 3)}) == 8


def test_the_first_workers_do_not_depend_on_the_others():
    assert draw_workers(40, 7)[:5] == draw_workers(5, 7)


@given(st.from_regex(r"[a-z]{4,12}", fullmatch=True), st.integers(0, 10**6))
def test_a_slip_keeps_the_first_and_the_last_letter(word, seed):
    typed = misspell(word, np.random.default_rng(seed))
    assert typed[0] == word[0]
    assert abs(len(typed) - len(word)) <= 1


def test_an_action_that_nobody_has_words_for():
    objects = {"tires-1": Thing("tire-pallet", (8.0, 0.0))}
    made = scenario(objects, (ScriptStep("wait", 2.0),))
    with pytest.raises(CorpusError, match="wait"):
        tell(see(made), EXACT, np.random.default_rng(0))
