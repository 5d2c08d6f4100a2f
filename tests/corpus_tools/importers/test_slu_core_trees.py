from __future__ import annotations

import pytest

from corpus_tools.importers.slu_core.slu_trees import read_trees
from g3.errors import FormatError
from g3.sdc.clauses import SDC, Span

TEXT = "Put  the pallet down near the\r\ntruck, the pallet"


def words(*items: tuple[int, str]) -> tuple[Span, ...]:
    return tuple(Span(start, text) for start, text in items)


IMPLICIT = SDC("OBJECT")


def read(fields: object, kind: str = "EVENT", text: str = TEXT) -> SDC:
    (sdc,) = read_trees([{kind: fields}], text)
    return sdc


def test_a_string_becomes_the_spans_of_its_words():
    assert read({"r": " down near "}).relation == words((16, "down"), (21, "near"))


def test_white_space_between_words_may_differ():
    assert read({"f": "near the truck"}, "OBJECT").words == words(
        (21, "near"), (26, "the"), (31, "truck,"[:5])
    )


def test_tokens_are_taken_as_they_are_and_split():
    value = [["Put", [0, 3]], ["pallet down", [9, 20]]]
    assert read({"r": value}).relation == words((0, "Put"), (9, "pallet"), (16, "down"))


def test_words_in_landmarks_become_objects():
    sdc = read({"l": "truck", "l2": "near"}, "PLACE")
    assert sdc.landmark1 == (SDC("OBJECT", words=words((31, "truck"))),)
    assert sdc.landmark2 == (SDC("OBJECT", words=words((21, "near"))),)
    assert sdc.figure == ()


@pytest.mark.parametrize("fields", [{"f": "truck"}, {"f": "truck", "r": "down"}])
def test_words_in_the_figure_of_an_event_become_an_object(fields):
    sdc = read(fields)
    assert sdc.words == ()
    assert sdc.figure == (SDC("OBJECT", words=words((31, "truck"))),)


@pytest.mark.parametrize("field", ["r", "l", "l2"])
@pytest.mark.parametrize("kind", ["OBJECT", "PLACE", "PATH"])
def test_words_in_the_figure_become_an_object_where_another_field_is_filled(kind, field):
    sdc = read({"f": "truck", field: "down"}, kind)
    assert sdc.words == ()
    assert sdc.figure == (SDC("OBJECT", words=words((31, "truck"))),)


def test_words_in_the_figure_of_a_leaf_stay():
    assert read({"f": "truck", "r": "", "l": [], "l2": None}, "OBJECT") == SDC(
        "OBJECT", words=words((31, "truck"))
    )


@pytest.mark.parametrize("fields", [None, {}, {"f": None}, {"f": []}, {"f": "  ", "r": "down"}])
def test_an_event_without_figure_gets_the_implicit_robot(fields):
    assert read(fields).figure == (IMPLICIT,)


def test_a_list_of_clauses():
    sdc = read({"l": [{"OBJECT": {"f": "truck"}}, {"PATH": {"r": "down"}}]})
    assert [child.type for child in sdc.landmark1] == ["OBJECT", "PATH"]


@pytest.mark.parametrize(
    ("value", "where", "what"),
    [
        ("words", "command[1]", "not a list"),
        (["words"], "command[1][0]", "not an SDC"),
        ([{"THING": {}}], "command[1][0].THING", "no type"),
        ([{"EVENT": {}, "PATH": {}}], "command[1][0]", "not an SDC"),
        ([{"EVENT": {"x": "Put"}}], "command[1][0].EVENT", "mapping of f, r, l and l2"),
        ([{"EVENT": {"r": {"PATH": {}}}}], "command[1][0].EVENT.r", "relation holds an SDC"),
        ([{"EVENT": {"r": 3}}], "command[1][0].EVENT.r", "holds a int"),
        ([{"EVENT": {"l": "the pallet"}}], "command[1][0].EVENT.l", "occurs 2 times"),
        ([{"EVENT": {"l": "lorry"}}], "command[1][0].EVENT.l", "occurs 0 times"),
        ([{"EVENT": {"r": [["Put", [1, 4]]]}}], "command[1][0].EVENT.r[0]", "'ut ' does"),
        ([{"EVENT": {"r": [["Put", [-48, 3]]]}}], "command[1][0].EVENT.r[0]", "doesn't stand"),
        ([{"EVENT": {"r": [["Put", 0]]}}], "command[1][0].EVENT.r[0]", "neither a word"),
        ([{"EVENT": {"l": [{"PATH": {"l": [["Put", [0, 2]]]}}]}}],
         "command[1][0].EVENT.l[0].PATH.l[0]", "doesn't stand"),
    ],
)  # fmt: skip
def test_what_cannot_be_read(value, where, what):
    with pytest.raises(FormatError) as caught:
        read_trees(value, TEXT)
    assert caught.value.where == where
    assert what in caught.value.what
    assert caught.value.fix
