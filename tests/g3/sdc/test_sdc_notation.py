from __future__ import annotations

import contextlib
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from g3.errors import SDCError
from g3.sdc.clauses import SDC, Span, all_words, breadth_first
from g3.sdc.sdc_notation import (
    MAX_DEPTH,
    check_sdc,
    format_brackets,
    from_json,
    parse_brackets,
    to_json,
)
from tests.strategies import sdc_trees

FIGURE_2A = (
    "EVENT_1(r = Put, l = OBJ_2(f = the pallet), l2 = PLACE_3(r = on, l = OBJ_4(f = the truck)))"
)
FIGURE_3A = """EVENT_1(r = Go
  l = PATH_2(r = to,
    l = OBJ_3(f = OBJ_4(f = the pallet),
      r = on,
      l = OBJ_5(f = the truck))))""".replace("Go\n", "Go,\n")  # a comma that the paper forgot

forests = st.lists(sdc_trees(), max_size=3).map(tuple)


def leaf(text: str, start: int) -> SDC:
    spans = []
    for word in text.split():
        spans.append(Span(start, word))
        start += len(word) + 1
    return SDC("OBJECT", tuple(spans))


def test_figure_2a_is_read():
    (event,) = parse_brackets(FIGURE_2A, command="Put the pallet on the truck.")
    assert event == SDC(
        "EVENT",
        relation=(Span(0, "Put"),),
        figure=(SDC("OBJECT"),),
        landmark1=(leaf("the pallet", 4),),
        landmark2=(SDC("PLACE", relation=(Span(15, "on"),), landmark1=(leaf("the truck", 18),)),),
    )


def test_figure_2a_is_printed_as_in_the_paper():
    assert format_brackets(parse_brackets(FIGURE_2A)) == FIGURE_2A


def test_figure_3a_is_read_over_several_lines():
    (event,) = parse_brackets(FIGURE_3A, command="Go to the pallet on the truck")
    assert [node.type for node in breadth_first([event])] == (
        ["EVENT", "OBJECT", "PATH", "OBJECT", "OBJECT", "OBJECT"]
    )
    assert format_brackets([event]) == " ".join(FIGURE_3A.split())


def test_numbers_run_over_the_whole_command():
    text = "EVENT(r = Stop)\nEVENT(r = Go, l = PATH(r = on))"
    assert format_brackets(parse_brackets(text)) == (
        "EVENT_1(r = Stop)\nEVENT_2(r = Go, l = PATH_3(r = on))"
    )


@pytest.mark.parametrize("separator", ["\n", ";", "\r\n", " ; \n\n "])
def test_clauses_are_separated_by_lines_or_semicolons(separator):
    assert len(parse_brackets(f"EVENT(r = Stop){separator}EVENT(r = Go){separator}")) == 2


def test_other_spellings_are_read():
    usual = parse_brackets("EVENT_1(r = a, l = OBJ_2(f = b), l2 = OBJ_3(f = c))")
    assert parse_brackets('EVENT(l_1=[OBJECT7(f=b)],l_2=OBJ(f="c"),r="a")') == usual


def test_several_clauses_in_a_field():
    (place,) = parse_brackets("PLACE(r = between, l = [OBJ(f = it), OBJ(f = them)])")
    assert [child.words[0].text for child in place.landmark1] == ["it", "them"]
    assert format_brackets([place]) == "PLACE_1(r = between, l = [OBJ_2(f = it), OBJ_3(f = them)])"


def test_figure_of_an_event():
    assert parse_brackets("EVENT(r = Go)")[0].figure == (SDC("OBJECT"),)
    assert parse_brackets("EVENT(f = [], r = Go)")[0].figure == ()
    assert parse_brackets("EVENT(f = OBJ(f = you), r = go)")[0].figure == (leaf("you", 0),)
    assert parse_brackets("PLACE(r = there)")[0].figure == ()
    assert format_brackets([SDC("EVENT")]) == "EVENT_1(f = [])"


def test_positions_are_written_and_read():
    put_down = SDC("EVENT", relation=(Span(0, "Put"), Span(19, "down")), figure=(SDC("OBJECT"),))
    assert format_brackets([put_down], positions=True) == "EVENT_1(r = Put@0 down@19)"
    assert parse_brackets("EVENT_1(r = Put@0 down@19)") == (put_down,)


def test_words_that_look_like_notation_are_quoted():
    words = (Span(0, "a,b"), Span(4, 'say"'), Span(9, "x@y"), Span(13, "\x00"))
    text = format_brackets([SDC("OBJECT", words)])
    assert text == r'OBJ_1(f = "a,b" "say\"" "x@y" "\u0000")'
    assert parse_brackets(text) == (SDC("OBJECT", words),)


@given(forests)
def test_round_trip_with_positions(sdcs):
    assert parse_brackets(format_brackets(sdcs, positions=True)) == sdcs


@given(forests)
def test_round_trip_without_positions(sdcs):
    text = format_brackets(sdcs)
    again = parse_brackets(text)
    assert format_brackets(again) == text
    words = [word for sdc in again for word in all_words(sdc)]
    command = " ".join(word.text for word in sorted(words))
    assert all(command[word.start : word.end] == word.text for word in words)


@given(forests)
def test_round_trip_through_json(sdcs):
    assert from_json(json.loads(json.dumps(to_json(sdcs)))) == sdcs


NOTATION_PIECES = st.sampled_from(
    ["EVENT", "OBJ_2", "(", ")", "[", "]", "=", ",", ";", "\n", " ", "f", "r", "l", '"', "@3", "x"]
)


@given(st.text() | st.lists(NOTATION_PIECES, max_size=30).map("".join), st.none() | st.text())
def test_any_text_is_read_or_refused_properly(text, command):
    try:
        sdcs = parse_brackets(text, command=command)
    except SDCError:
        return
    for sdc in sdcs:
        check_sdc(sdc)
        if command is not None:
            assert all(command[w.start : w.end] == w.text for w in all_words(sdc))


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text(max_size=5),
    lambda children: (
        st.lists(children, max_size=3)
        | st.dictionaries(st.sampled_from(["type", "f", "r", "l", "l2", "x"]), children)
        | st.builds(lambda d: {"type": "OBJECT", **d}, st.dictionaries(st.just("f"), children))
    ),
)


@given(json_values)
def test_any_json_is_read_or_refused_properly(value):
    try:
        sdcs = from_json(value)
    except SDCError:
        return
    assert from_json(to_json(sdcs)) == sdcs


@pytest.mark.parametrize(
    ("notation", "message"),
    [
        (
            "pallet",
            "column 1: expected a clause, but found 'pallet' (such as OBJ(f = the pallet); ",
        ),
        ("EVENT", "column 6: expected '(' after EVENT, but the notation ends"),
        ("EVENT(", "column 7: expected a field: f, r, l or l2, but the notation ends"),
        ("EVENT(r = Put", "column 14: expected ',' or ')', but the notation ends"),
        ("EVENT(r = )", "column 11: expected words, but found ')'"),
        ("EVENT(r Put)", "column 9: expected '=' after r, but found 'Put'"),
        ("PLACE(r = OBJ())", "column 11: expected words in the relation field, but found 'OBJ'"),
        ("OBJ(f = a, f = b)", "column 12: the field f is given twice"),
        ("OBJ(f = a)\n\nOBJ(x = b)", "line 3, column 5: expected a field: f, r, l or l2, but fo"),
        ("OBJ() OBJ()", "column 7: expected a new line or ';' between clauses, but found 'OBJ'"),
        ("OBJ(f = tires (2))", "column 15: expected ',' or ')', but found '(' (quote a word that"),
        ("OBJ(l = the truck)", "column 9: expected a clause or a list of clauses, but found 'the'"),
        ("OBJ(f = a, r = on)", "column 1: the figure holds words though other fields are filled"),
        ('OBJ(f = "a)', "column 9: expected words or a clause, but found '\"' (the quoted word ha"),
        ('OBJ(f = "a b")', 'column 9: "a b" is not one word (quote each word by itself)'),
        (r'OBJ(f = "\x")', r'column 9: "\x" is not a JSON string'),
        ("OBJ(f = a @3)", "column 11: expected ',' or ')', but found '@3'"),
        ("OBJ(f = a@b)", "column 10: expected ',' or ')', but found '@' (a position is '@' and"),
        ("OBJ(f = a@1 b)", "column 13: the word 'b' has no position though others have one"),
        ("OBJ(l = [OBJ()", "column 15: expected ',' or ']', but the notation ends"),
        ("OBJ(f=" * 10_000, "column 385: clauses nest deeper than 64 levels"),
    ],
)
def test_errors_say_where_and_what_was_expected(notation, message):
    with pytest.raises(SDCError) as caught:
        parse_brackets(notation)
    assert str(caught.value).startswith(message)


def nested(depth: int) -> SDC:
    sdc = SDC("OBJECT")
    for _ in range(depth - 1):
        sdc = SDC("OBJECT", relation=(Span(0, "of"),), landmark1=(sdc,))
    return sdc


def test_nesting_is_limited_everywhere():
    deepest = (nested(MAX_DEPTH),)
    assert parse_brackets(format_brackets(deepest, positions=True)) == deepest
    assert from_json(to_json(deepest)) == deepest
    for write in (format_brackets, to_json):
        with pytest.raises(SDCError, match="deeper than 64"):
            write([nested(5000)])
    value = {"type": "OBJECT"}
    for _ in range(5000):
        value = {"type": "OBJECT", "l": [value]}
    with pytest.raises(SDCError, match="deeper than 64"):
        from_json([value])


@pytest.mark.parametrize(
    ("sdc", "message"),
    [
        (SDC("OBJECT", (Span(0, "a"),), relation=(Span(2, "b"),)), "SDC: the figure holds words"),
        (SDC("OBJECT", (Span(0, "a b"),)), "SDC.f: 'a b' is not a word"),
        (SDC("OBJECT", (Span(0, ""),)), "SDC.f: '' is not a word"),
        (SDC("OBJECT", (Span(-1, "a"),)), "SDC.f: the word 'a' has the position -1"),
        (SDC("THING"), "SDC: there is no type 'THING'"),  # type: ignore[arg-type]
        (SDC("PATH", landmark2=(SDC("PATH", relation=(Span(0, ""),)),)), "SDC.l2[0].r: '' is not"),
    ],
)
def test_ill_formed_trees_are_refused(sdc, message):
    with pytest.raises(SDCError) as caught:
        check_sdc(sdc)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ({}, "SDCs: expected a list of clauses"),
        (["EVENT"], "SDC 1: expected a clause, an object with a type"),
        ([{"type": "EVENT"}, {}], "SDC 2: there is no type None (give one of EVENT, OBJECT"),
        ([{"type": []}], "SDC 1: there is no type []"),
        ([{"type": "PATH", "g": []}], "SDC 1: there is no field 'g'"),
        ([{"type": "PATH", "r": "on"}], "SDC 1.r: expected a list of words or clauses"),
        ([{"type": "PATH", "r": [["on", True]]}], "SDC 1.r[0]: expected a word, [text, start]"),
        ([{"type": "PATH", "l": [{"type": "PATH", "r": [3]}]}], "SDC 1.l[0].r[0]: expected a word"),
    ],
)
def test_errors_in_json_say_where(value, message):
    with pytest.raises(SDCError) as caught:
        from_json(value)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    "piece", ["(", "[", '"', '"\\', "@", "😀", "OBJ(f = ", "OBJ(f = a)\n", "x ", "\n", ";"]
)
def test_a_notation_of_any_length_is_refused_at_once(piece):
    with pytest.raises(SDCError, match="the text has 100001 characters, the limit is 100000"):
        parse_brackets((piece * 100_001)[:100_001])
    with contextlib.suppress(SDCError):  # within the limit, it is read in time that grows with it
        parse_brackets((piece * 100_000)[:100_000])
