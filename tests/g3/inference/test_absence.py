"""Commands about what isn't there."""

from dataclasses import replace

import pytest

from corpus_tools.importers.authored.bundled import open_corpus
from g3.actions.robot_state import start_state
from g3.inference.absence import absent_nouns, what_is_missing
from g3.inference.grounder import Grounder
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.costs import RandomCost
from g3.sdc.sdc_notation import parse_brackets
from tests.worlds import place, thing


@pytest.fixture(scope="module")
def dock():
    return open_corpus("warehouse").contexts["dock_pick_up_tires"]


def lift(noun):
    return parse_brackets(f"EVENT(r = Lift, l = OBJ(f = the {noun}))")


def test_nothing_is_planned_about_what_is_not_there_unless_somebody_insists(dock):
    grounder = Grounder(RandomCost(1))
    found = grounder.follow(lift("elephant"), dock, least=0.0)
    assert found.plans == ()
    assert found.missing == ("elephant",)
    assert found.note.startswith("I see no elephant here. There are: ")
    assert "tire pallet" in found.note
    insisted = grounder.follow(lift("elephant"), dock, least=0.0, insist=True)
    assert insisted.plan is not None
    assert insisted.missing == ("elephant",)


def test_what_is_there_is_planned_for(dock):
    found = Grounder(RandomCost(1)).follow(lift("crate"), dock, least=0.0)
    assert found.missing == ()
    assert found.plan is not None


def test_a_thing_that_was_removed_is_missed(dock):
    poorer = replace(dock, objects=tuple(o for o in dock.objects if "crate" not in o.labels))
    pallets = replace(dock, objects=tuple(o for o in dock.objects if "pallet" not in o.labels))
    assert absent_nouns(Tree(lift("tires")), dock) == ()
    assert absent_nouns(Tree(lift("tires")), pallets) == ("tires",)
    assert absent_nouns(Tree(lift("barrel")), poorer) == ()


@pytest.mark.parametrize("noun", ["truck", "trailer", "barrel"])
def test_a_known_kind_of_thing_is_not_another_however_alike(dock, noun):
    kinds = {"box": "box pallet", "tires": "tire pallet", "worker": "person", "shelf": "shelf"}
    objects = [thing(name, labels, 1, 1) for name, labels in kinds.items()]
    world = replace(dock, objects=(dock.agent, *objects), places=())
    assert absent_nouns(Tree(lift(noun)), world) == (noun,)
    with_it = replace(world, objects=(*world.objects, thing("it", noun, 3, 1)))
    assert absent_nouns(Tree(lift(noun)), with_it) == ()
    for loosely in ("pallet", "box"):  # of whatever is to be moved
        assert absent_nouns(Tree(lift(loosely)), world) == ()


def test_what_only_tells_which_thing_is_meant_is_let_pass(dock):
    near = parse_brackets(
        "EVENT(r = Lift, l = OBJ(f = OBJ(f = the pallet), r = by, l = OBJ(f = the wall)))"
    )
    goal = parse_brackets("EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the elephant)))")
    assert absent_nouns(Tree(near), dock) == ()
    assert absent_nouns(Tree(goal), dock) == ("elephant",)


def test_places_are_there_by_their_names(dock):
    world = replace(dock, objects=(dock.agent,), places=(place("garage", (3, 3)),))
    assert absent_nouns(Tree(lift("garage")), world) == ()
    assert absent_nouns(Tree(lift("truck")), world) == ("truck",)


def test_what_there_is_is_counted_in_plain_words(dock):
    objects = (
        dock.agent,
        thing("a", "tire pallet", 1, 1),
        thing("b", "tire pallet", 2, 1),
        thing("c", "operator", 3, 1),
        thing("d", "box", 4, 1),
        thing("e", "box", 5, 1),
    )
    world = replace(dock, objects=objects, places=(place("gate", (3, 3)),))
    assert what_is_missing(("truck",), world) == (
        "I see no truck here. There are: two tire pallets, an operator, two boxes, gate"
    )
    assert start_state(world)
