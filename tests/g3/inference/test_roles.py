"""What parts the clauses inside a clause play."""

import pytest

from g3.inference.problem.clause_roles import (
    goal_paths,
    goal_places,
    goal_within,
    objects,
    subjects,
    tells_place,
    ways,
)
from g3.inference.problem.frames import frame, is_itself_put_later, is_put_later, spares
from g3.sdc.clauses import all_words
from g3.sdc.sdc_notation import parse_brackets
from tests.g3.inference.ruled import tree_of


def words(tree, node):
    return " ".join(word.text for word in all_words(tree.nodes[node]))


def test_what_something_is_taken_from_is_no_goal():
    tree = tree_of(
        "EVENT(r = Move, l = OBJ(f = the pallet), l2 = [PATH(r = from, l = OBJ(f = a truck)), "
        "PATH(r = to, l = OBJ(f = the other))])"
    )
    (goal,) = goal_paths(tree, 0)
    assert [w.text for w in tree.nodes[goal].relation] == ["to"]


def test_what_is_passed_is_no_goal_if_another_path_has_one():
    tree = tree_of(
        "EVENT(r = Drive, l2 = [PATH(r = past, l = OBJ(f = the barrel)), "
        "PATH(r = to, l = OBJ(f = the truck))])"
    )
    assert [w.text for w in tree.nodes[goal_paths(tree, 0)[0]].relation] == ["to"]


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


def test_who_goes_with_something_goes_to_nothing():
    found = tree_of("EVENT(r = Go, l = PATH(r = with, l = OBJ(f = the pallet)))")
    assert goal_paths(found, 0) == []
    assert [words(found, n) for n in ways(found, 0)] == ["with the pallet"]


def test_a_place_may_be_where_something_is_taken_from():
    found = tree_of(
        "EVENT(r = Fetch, l = OBJ(f = it), l2 = [PLACE(r = from, l = OBJ(f = truck A)), "
        "PLACE(r = on, l = OBJ(f = truck B))])"
    )
    assert [words(found, n) for n in goal_places(found, 0)] == ["on truck B"]
    assert [words(found, n) for n in ways(found, 0)] == ["from truck A"]


@pytest.mark.parametrize(
    ("notation", "handled"),
    [
        (
            "EVENT(r = Load, l = OBJ(f = the tires), l2 = PLACE(r = on, l = OBJ(f = it)))",
            "the tires",
        ),
        ("EVENT(r = Load with, l = OBJ(f = the truck), l2 = OBJ(f = the tires))", "the tires"),
        (
            "EVENT(f = OBJ(f = the boxes), r = should be, l = PLACE(r = on, l = OBJ(f = it)))",
            "the boxes",
        ),
        ("EVENT(f = OBJ(f = you), r = need, l = OBJ(f = the boxes))", "the boxes"),
        ("EVENT(r = Back up, l = OBJ(f = a bit))", ""),
    ],
)
def test_what_is_handled_comes_first(notation, handled):
    found = tree_of(notation)
    first = objects(found, 0)[:1]
    assert [words(found, n) for n in first] == ([handled] if handled else [])


def test_who_is_spoken_to_is_no_subject():
    assert subjects(tree_of("EVENT(f = OBJ(f = you), r = go)"), 0) == []


def test_another_clause_may_tell_where_to():
    found = tree_of(
        "EVENT(r = Drive, l = EVENT(r = until, l = EVENT(f = OBJ(f = you), r = are, "
        "l = PLACE(r = inside, l = OBJ(f = the storage)))))"
    )
    assert words(found, goal_within(found, 0)) == "inside the storage"
    assert goal_within(tree_of("EVENT(r = Drive, l = EVENT(f = OBJ(f = you), r = see))"), 0) is None


def test_what_is_put_down_without_a_place_is_left_open():
    assert frame(tree_of("EVENT(r = set down, l = OBJ(f = it))"), 0).leaves_open
    there = tree_of("EVENT(r = set, l = OBJ(f = it), l2 = PLACE(r = there))")
    assert not frame(there, 0).leaves_open
    assert not frame(tree_of("EVENT(r = lift, l = OBJ(f = it))"), 0).leaves_open


def test_what_is_left_is_spared_unless_it_is_left_there():
    crate = tree_of("EVENT(r = leave, l = OBJ(f = the crate))")
    assert spares(crate, 0, None)
    assert not spares(crate, 0, "boxes")
    assert spares(tree_of("EVENT(r = leave alone, l = OBJ(f = the crate))"), 0, "boxes")
    assert not spares(tree_of("EVENT(r = leave, l = OBJ(f = it), l2 = PLACE(r = there))"), 0, None)


def test_a_later_clause_may_put_it_down():
    both = tree_of(
        "EVENT(r = Move, l = OBJ(f = the tires), l2 = PATH(r = to, l = OBJ(f = the truck))); "
        "EVENT(r = put down, l = OBJ(f = them))"
    )
    assert is_itself_put_later(both, 0)
    assert not is_itself_put_later(both, 1)
    other = tree_of(
        "EVENT(r = Move, l = OBJ(f = the tires)); EVENT(r = put, l = OBJ(f = the boxes))"
    )
    assert is_put_later(other, 0)
    assert not is_itself_put_later(other, 0)
