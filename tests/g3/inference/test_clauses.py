"""What an EVENT's words say by their class."""

import pytest

from g3.inference.clauses import UNUSUAL, Asked, goal_paths, tells_place, verb_scores
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
        ("Lift", {"carry", "put down"}),
        # Who leaves something goes away or puts it down.
        ("leave", {"pick up"}),
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


def dear(verb, **asked):
    (event,) = parse_brackets(f"EVENT(r = {verb}, l = OBJ(f = it))")
    costs = verb_scores(event, KINDS, Asked(theme=True, **asked))
    return {kind for kind, cost in zip(KINDS, costs, strict=True) if cost}


def test_who_moves_a_load_somewhere_puts_it_down_or_drives_there_with_it():
    assert dear("Move", leads=True) == {"wait", "drive to", "pick up"}
    assert dear("Move", leads=True, held="tires") == {"wait", "pick up"}
    assert dear("Move", leads=True, held="tires", at_place=True) == {"wait", "drive to", "pick up"}


def test_who_takes_something_picks_it_up_unless_the_forks_have_it():
    assert dear("Take") == {"wait", "drive to", "carry", "put down"}
    assert dear("Take", leads=True) == {"wait", "drive to", "put down"}
    assert dear("Take", held="tires") == {"carry", "put down"}


@pytest.mark.parametrize(
    ("notation", "place"),
    [
        ("PATH(r = beside, l = OBJ(f = the crate))", True),
        ("PATH(r = to the right of, l = OBJ(f = the crate))", True),
        ("PATH(r = to, l = OBJ(f = the truck))", False),
        ("PATH(r = to the right)", False),
    ],
)
def test_a_path_may_tell_a_place(notation, place):
    (path,) = parse_brackets(notation)
    assert tells_place(path) is place
