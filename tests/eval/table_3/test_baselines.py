"""Baselines without a model, in a yard with two loads and a trailer."""

import numpy as np
import pytest

from corpus_tools.following.plan_steps import carried_out
from eval.table_3 import baselines
from eval.table_3.baselines import missing
from eval.table_3.grounder_registry import PlanTask, grounder_named
from g3.actions.grounding_candidates import carrier
from g3.actions.logged_actions import centre
from g3.actions.robot_state import start_state
from g3.language.similarity import static_embeddings
from tests.eval.yard import yard

FRIDGE, WASHER = "11", "12"


@pytest.fixture(scope="module")
def start(tmp_path_factory):
    """The robot looks at the middle of its loads: the refrigerator is left, and nearer."""
    (context,) = yard(tmp_path_factory.mktemp("yard")).contexts.values()
    return start_state(context)


def plan(name, text, start, loads=(FRIDGE, WASHER)):
    things = tuple(start.thing(i) for i in loads)
    return grounder_named(name).propose(PlanTask(text, start, things), None).actions


def lifted(name, text, start):
    (action,) = plan(name, text, start)
    assert action.kind.name == "pick up"
    return action.object_id


@pytest.mark.parametrize(
    ("text", "load"),
    [
        ("Pick up the washing machine.", WASHER),
        ("Lift the machine, not the refrigerator!", WASHER),
        ("Take the REFRIGERATORS.", FRIDGE),
        # "Pallet" is a label of both, so that it tells nothing.
        ("Lift the pallet with the washing machine.", WASHER),
        ("Lift the right one.", WASHER),
        ("Lift the leftmost one.", FRIDGE),
        ("Lift it.", FRIDGE),
        # Of those alike there is one only.
        ("Lift the refrigerator on the right.", FRIDGE),
    ],
)
def test_keywords(text, load, start):
    assert lifted("keywords", text, start) == load


def test_the_nearest_load_whatever_is_said(start):
    for text in ("Lift the washing machine on the right.", "Lift it."):
        assert lifted("nearest", text, start) == FRIDGE


@pytest.mark.parametrize(
    ("text", "load"),
    [
        ("Pick up the washer.", WASHER),
        ("Pick up the dryer.", WASHER),
        ("Pick up the fridge on the right.", FRIDGE),
        ("Pick up the elephant on the right.", WASHER),
        ("Pick up the elephant.", FRIDGE),
    ],
)
def test_embeddings_know_words_that_are_no_labels(text, load, start):
    pytest.importorskip("wordllama")
    assert lifted("embeddings", text, start) == load


def test_embeddings_need_an_extra(monkeypatch):
    monkeypatch.setattr(static_embeddings, "find_spec", lambda _: None)
    assert missing() == {"embeddings": static_embeddings.MISSING}
    assert "pip install 'corpus-tools-g3[embeddings]'" in static_embeddings.MISSING


def test_embeddings_load_without_a_network():
    pytest.importorskip("wordllama")
    assert missing() == {}
    fridge, refrigerator, elephant = static_embeddings.vectors(
        ["fridge", "refrigerator", "elephant"]
    )
    assert fridge @ refrigerator > 0.7
    assert elephant @ refrigerator < baselines.LEAST_ALIKE


@pytest.mark.parametrize("name", ["nearest", "keywords"])
def test_a_load_goes_where_a_second_thing_is_named(name, start):
    actions = plan(name, "Put the refrigerator on the trailer.", start)
    assert [a.kind.name for a in actions] == ["carry"]
    final = carried_out(start, actions)
    assert carrier(final, FRIDGE).id == "13"
    assert final.held is None
    (down,) = plan(name, "Pick up the refrigerator and set it down.", start)
    assert carrier(carried_out(start, [down]), FRIDGE) is None
    (beside,) = plan(name, "Put the refrigerator beside the washing machine.", start)
    apart = centre(beside.place.prism) - centre(start.thing(WASHER).prism)
    assert beside.object_id == FRIDGE
    assert np.linalg.norm(apart) < 3
    # Named before the load, and without a word that says so, it is no goal.
    near = "Past the trailer is a refrigerator: lift it."
    assert [a.kind.name for a in plan(name, near, start)] == ["pick up"]


def test_a_command_that_only_goes_is_driven(start):
    (action,) = plan("keywords", "Drive to the trailer.", start)
    assert (action.kind.name, action.target[0].id) == ("drive to", "13")
    assert [a.kind.name for a in plan("keywords", "Turn around.", start)] == ["go straight"]
    assert carried_out(start, plan("keywords", "Go on.", start)).held is None


def test_without_a_load_there_is_no_plan(start):
    assert plan("keywords", "Lift the refrigerator.", start, loads=()) == []


def test_what_is_on_the_forks_is_put_down(start):
    loaded = carried_out(start, plan("keywords", "Lift the washing machine.", start))
    assert loaded.held == WASHER
    (action,) = plan("keywords", "Put the refrigerator on the trailer.", loaded)
    assert (action.kind.name, action.object_id) == ("put down", WASHER)
    assert carrier(carried_out(loaded, [action]), WASHER).id == "13"
