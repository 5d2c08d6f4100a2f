"""What an EVENT's words say by their class."""

import pytest

from g3.inference.clauses import UNUSUAL, goal_paths, verb_scores
from g3.inference.things import Tree
from g3.sdc_notation import parse_brackets

KINDS = ("wait", "drive to", "pick up", "put down")


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
        ("turn", {"pick up", "put down"}),
        ("wait", {"pick up", "put down"}),
        ("Set down", {"wait", "drive to"}),
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
