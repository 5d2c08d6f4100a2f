"""What an EVENT's words say by their class."""

import pytest

from g3.inference.clauses import UNUSUAL, goal_paths, verb_scores
from g3.inference.tree import Tree
from g3.sdc_notation import parse_brackets

KINDS = ("wait", "drive to", "pick up", "carry", "put down")


def test_what_something_is_taken_from_is_no_goal():
    tree = Tree(
        parse_brackets(
            "EVENT(r = Move, l = OBJ(f = the pallet), l2 = [PATH(r = from, l = OBJ(f = a truck)), "
            "PATH(r = to, l = OBJ(f = the other))])"
        )
    )
    (goal,) = goal_paths(tree, 0)
    assert [w.text for w in tree.nodes[goal].relation] == ["to"]


@pytest.mark.parametrize(
    ("verb", "unusual"),
    [
        ("turn", {"pick up", "carry", "put down"}),
        ("wait", {"pick up", "carry", "put down"}),
        ("Set down", {"wait", "drive to", "pick up"}),
        ("Lift", {"put down"}),
        # Who moves a load may drive it somewhere, pick it up or put it down.
        ("Move", set()),
        ("Flurb", set()),
    ],
)
def test_a_verb_is_of_a_sort_of_action(verb, unusual):
    (event,) = parse_brackets(f"EVENT(r = {verb}, l = OBJ(f = it))")
    costs = dict(zip(KINDS, verb_scores(event, KINDS).tolist(), strict=True))
    assert {kind for kind, cost in costs.items() if cost} == unusual
    assert set(costs.values()) <= {0.0, UNUSUAL}


def test_what_is_passed_is_no_goal_if_another_path_has_one():
    tree = Tree(
        parse_brackets(
            "EVENT(r = Drive, l2 = [PATH(r = past, l = OBJ(f = the barrel)), "
            "PATH(r = to, l = OBJ(f = the truck))])"
        )
    )
    assert [w.text for w in tree.nodes[goal_paths(tree, 0)[0]].relation] == ["to"]


def test_who_moves_a_load_somewhere_puts_it_down_or_drives_there_with_it():
    (event,) = parse_brackets("EVENT(r = Move, l = OBJ(f = it))")

    def dear(held):
        costs = verb_scores(event, KINDS, leads=True, held=held)
        return {kind for kind, cost in zip(KINDS, costs, strict=True) if cost}

    assert dear(None) == {"wait", "drive to", "pick up"}
    assert dear("tires") == {"wait", "pick up"}
