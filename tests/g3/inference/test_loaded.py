"""What a robot with a load on its forks is told to handle."""

from dataclasses import replace

import pytest

from corpus_tools.importers.authored.bundled import open_corpus
from g3.actions.robot_state import start_state
from g3.inference.grounder import Grounder
from g3.inference.potentials.cases import CommandCase
from g3.inference.potentials.potential_registry import refusal
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.grounding_problem import GroundingProblem
from g3.inference.problem.packed_scene import scene_of
from g3.sdc.sdc_notation import parse_brackets
from tests.g3.inference.constant_cost import ConstantCost


@pytest.fixture(scope="module")
def loaded():
    """Boxes are on the forks; a crate, tires and other boxes stand about."""
    return start_state(open_corpus("warehouse").contexts["depot_go_to_receiving_loaded"])


def in_state(state):
    return GroundingProblem(state, scene_of(state.context), ConstantCost())


def trees(text, sdcs):
    return parse_brackets(sdcs, command=text)


CRATE = (
    "EVENT_1(r = Put, l = OBJ_2(f = the crate), l2 = PLACE_3(r = on, l = OBJ_4(f = the trailer)))"
)


@pytest.mark.parametrize(
    ("text", "sdcs", "in_the_way"),
    [
        ("Put the crate on the trailer", CRATE, True),
        ("Lift the tires", "EVENT_1(r = Lift, l = OBJ_2(f = the tires))", True),
        ("Lift the crates", "EVENT_1(r = Lift, l = OBJ_2(f = the crates))", True),
        ("Put down the boxes", "EVENT_1(r = Put down, l = OBJ_2(f = the boxes))", False),
        ("Put down the pallet", "EVENT_1(r = Put down, l = OBJ_2(f = the pallet))", False),
        ("Place it", "EVENT_1(r = Place, l = OBJ_2(f = it))", False),
        ("Go to the crate", "EVENT_1(r = Go, l = PATH_2(r = to, l = OBJ_3(f = the crate)))", False),
        ("Don't lift the crate", "EVENT_1(r = Don't lift, l = OBJ_2(f = the crate))", False),
        ("Leave alone the crate", "EVENT_1(r = Leave alone, l = OBJ_2(f = the crate))", False),
        ("Lift the zeppelin", "EVENT_1(r = Lift, l = OBJ_2(f = the zeppelin))", False),
        (
            "Put down, lift the crate",
            "EVENT_1(r = Put down); EVENT_2(r = lift, l = OBJ_3(f = the crate))",
            False,
        ),
        (
            "Leave alone the boxes, lift the crate",
            "EVENT_1(r = Leave alone, l = OBJ_2(f = the boxes));"
            " EVENT_3(r = lift, l = OBJ_4(f = the crate))",
            True,
        ),
        (
            "Place it, lift the crate",
            "EVENT_1(r = Place, l = OBJ_2(f = it)); EVENT_3(r = lift, l = OBJ_4(f = the crate))",
            False,
        ),
    ],
)
def test_another_load_by_its_name_has_to_wait(loaded, text, sdcs, in_the_way):
    problem, tree = in_state(loaded), Tree(trees(text, sdcs))
    why = refusal(CommandCase(tree, problem))
    assert ("boxes-1" in why) is in_the_way
    off = replace(problem, disabled=frozenset({"load-in-the-way"}))
    assert not refusal(CommandCase(tree, off))


def test_free_forks_take_anything():
    free = start_state(open_corpus("warehouse").contexts["court_put_crate_on_trailer"])
    tree = Tree(trees("Put the crate on the trailer", CRATE))
    assert refusal(CommandCase(tree, in_state(free))) == ""


def test_the_robot_says_what_it_holds(loaded):
    result = Grounder(ConstantCost()).follow(trees("Put the crate on the trailer", CRATE), loaded)
    assert result.plans == ()
    assert result.note == "the box pallet boxes-1 is on the forks: have it put down first"
