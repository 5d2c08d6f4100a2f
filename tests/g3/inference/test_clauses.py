"""What an EVENT's words say by their class."""

import pytest

from g3.inference.actions import Action
from g3.inference.clauses import UNUSUAL, Asked, goal_scores, verb_scores
from g3.inference.tree import Tree
from g3.sdc_notation import parse_brackets

KINDS = ("wait", "drive to", "pick up", "carry", "put down")


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
        # Nobody picks something up because of a word that isn't known.
        ("Flurb", {"pick up", "carry", "put down"}),
    ],
)
def test_a_verb_is_of_a_sort_of_action(verb, unusual):
    (event,) = parse_brackets(f"EVENT(r = {verb}, l = OBJ(f = it))")
    costs = dict(zip(KINDS, verb_scores(event, KINDS).tolist(), strict=True))
    assert {kind for kind, cost in costs.items() if cost} == unusual
    assert set(costs.values()) <= {0.0, UNUSUAL, 2 * UNUSUAL}


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


def test_what_the_command_has_had_picked_up_is_put_down_at_the_end():
    taken = {"leads": True, "held": "tires", "taken": True}
    assert dear("Move", **taken) == dear("Take", **taken) == {"wait", "drive to", "pick up"}
    assert dear("Go", **taken) == {"pick up", "carry", "put down"}


def test_who_is_told_to_put_it_down_later_does_not_yet():
    assert dear("Move", leads=True, put_later=True) == {"carry", "put down"}


def test_forks_that_are_lowered_put_down_what_is_on_them():
    assert dear("Lower", forks=True, held="tires") == {"wait", "drive to", "pick up", "carry"}
    assert dear("Lower", forks=True) == {"pick up", "carry", "put down"}
    assert dear("Lift", forks=True) == {"pick up", "carry", "put down"}


def test_what_is_to_be_left_alone_is_not_handled():
    assert dear("leave", spared=True) == {"pick up", "carry", "put down"}


def test_a_thing_that_is_to_be_somewhere_is_carried_there():
    assert dear("should be", subject=True, leads=True) == {"wait", "drive to", "pick up"}


def test_who_goes_to_something_goes_there():
    tree = Tree(
        parse_brackets(
            "EVENT(r = Go, l2 = [PATH(r = past, l = OBJ(f = the barrel)), "
            "PATH(r = to, l = OBJ(f = the truck))])"
        )
    )
    actions = [Action("drive to", goal=0), Action("drive past")]
    past, to = tree.below(0, ("l2",), "PATH")
    assert goal_scores(tree, to, actions).tolist() == [0, UNUSUAL]
    assert not goal_scores(tree, past, actions).any()
    assert not goal_scores(tree, -1, actions).any()
