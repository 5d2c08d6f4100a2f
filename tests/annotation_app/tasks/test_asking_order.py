"""What people are asked first."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from annotation_app.tasks.clause_words import asked_clauses, clauses_of
from g3.language.discourse.anaphora import anaphors
from g3.sdc.clauses import child_indices
from g3.sdc.sdc_notation import parse_brackets
from tests.strategies import sdc_trees, with_text


def asked(notation: str, command: str) -> list[str]:
    return [c["phrase"] for c in asked_clauses(parse_brackets(notation, command=command))]


def test_what_a_pronoun_stands_for_comes_first_and_videos_last() -> None:
    command = "Go to the box pallet, lift it and put it on the trailer by the wall"
    notation = (
        "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the box pallet))); EVENT(r = lift, l = OBJ(f = "
        "it)); EVENT(r = put, l = OBJ(f = it), l2 = PLACE(r = on, l = OBJ(f = OBJ(f = the trailer),"
        " r = by, l = OBJ(f = the wall))))"
    )
    assert asked(notation, command) == [
        "the box pallet",
        "it",
        "it",
        "the trailer",
        "the wall",
        "the trailer by the wall",
        "on the trailer by the wall",
        "Go to the box pallet",
        "to the box pallet",
        "lift it",
        "put it on the trailer by the wall",
    ]


def test_a_pronoun_waits_for_what_its_modifier_ends_later() -> None:
    """The words of “the crate that is behind it” end after “it”, which stands for the truck."""
    command = "Take the crate behind it"
    notation = "EVENT(r = Take, l = OBJ(f = OBJ(f = the crate), r = behind, l = OBJ(f = it)))"
    assert asked(notation, command)[:3] == ["the crate", "it", "the crate behind it"]


def test_words_for_several_things_are_told_and_the_event_of_a_path() -> None:
    command = "Drive to the tires and lift them near it"
    notation = (
        "EVENT(r = Drive, l = PATH(r = to, l = OBJ(f = the tires))); "
        "EVENT(r = lift, l = OBJ(f = them), l2 = PLACE(r = near, l = OBJ(f = it)))"
    )
    found = {c["phrase"]: c for c in asked_clauses(parse_brackets(notation, command=command))}
    assert {phrase: c["several"] for phrase, c in found.items() if c["type"] == "OBJECT"} == {
        "the tires": True,
        "them": True,
        "it": False,
    }
    drive = found["Drive to the tires"]["node"]
    assert found["to the tires"]["during"] == drive
    assert found["Drive to the tires"]["during"] is None


def follows(notation: str, command: str) -> dict[str, str]:
    """Return the phrase that each phrase follows from."""
    found = asked_clauses(parse_brackets(notation, command=command))
    phrases = {clause["node"]: clause["phrase"] for clause in found}
    return {c["phrase"]: phrases[c["follows"]] for c in found if c["follows"] is not None}


def test_what_need_not_be_asked_follows_from_something_that_is() -> None:
    command = "Take the cup by the sink, wash it and put it by the sink, not by a sink"
    notation = (
        "EVENT(r = Take, l = OBJ(f = OBJ(f = the cup), r = by, l = OBJ(f = the sink))); EVENT(r = "
        "wash, l = OBJ(f = it)); EVENT(r = put, l = OBJ(f = it), l2 = PLACE(r = by, l = OBJ(f = the"
        " sink))); EVENT(r = not, l = PLACE(r = by, l = OBJ(f = a sink)))"
    )
    assert follows(notation, command) == {
        "the cup": "the cup by the sink",
        "it": "it",  # the second; the first is the cup
        "the sink": "the sink",
    }
    by_node = {
        clause["node"]: clause
        for clause in asked_clauses(parse_brackets(notation, command=command))
    }

    def source(node: int) -> int:
        before = by_node[node]["follows"]
        return node if before is None else source(before)

    it = [node for node, clause in by_node.items() if clause["phrase"] == "it"]
    assert {by_node[source(node)]["phrase"] for node in it} == {"the cup by the sink"}


@settings(max_examples=40)
@given(st.lists(sdc_trees(), min_size=1, max_size=3))
def test_each_clause_is_asked_once_and_after_what_it_needs(trees: list) -> None:
    _, sdcs = with_text(tuple(trees))
    order = [clause["node"] for clause in asked_clauses(sdcs)]
    sources = {clause["node"]: clause["follows"] for clause in asked_clauses(sdcs)}
    for node in order:  # it ends: something is asked
        for _ in order:
            before = sources[node]
            node = node if before is None else before  # noqa: PLW2901
        assert sources[node] is None
    assert sorted(order) == sorted(clause["node"] for clause in clauses_of(sdcs))
    types = {c["node"]: c["type"] for c in clauses_of(sdcs)}
    things = [node for node in order if types[node] in ("OBJECT", "PLACE")]
    assert order[: len(things)] == things
    at = {node: i for i, node in enumerate(order)}
    for node, children in enumerate(child_indices(sdcs)):
        for child in (c for group in children.values() for c in group):
            if node in at and child in at and node in things and child in things:
                assert at[child] < at[node]
    inside = {
        child: node
        for node, children in enumerate(child_indices(sdcs))
        for group in children.values()
        for child in group
    }

    def hosts(node: int) -> set[int]:
        return {inside[node], *hosts(inside[node])} if node in inside else set()

    for anaphor in anaphors(sdcs):
        for antecedent in anaphor.antecedents:
            if antecedent.index in at and antecedent.index not in hosts(anaphor.index):
                assert at[antecedent.index] < at[anaphor.index]
