from __future__ import annotations

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from corpus_tools.world.scenarios.documents import Problem, parse_document, read_document
from g3.errors import FormatError

TEXT = """\
title: A test  # a comment
items:
  one: {at: [1, 2.5]}
list:
  - on: yes
"""


def parse(text):
    return parse_document(text.encode(), "x.yaml")


def test_values_and_their_lines():
    document = parse(TEXT)
    assert document.value == {
        "title": "A test",
        "items": {"one": {"at": [1, 2.5]}},
        "list": [{"on": "yes"}],
    }
    assert document.marks["items", "one", "at", 1] == (3, 17)
    assert document.keys["list", 0, "on"] == (5, 5)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("~", None), ("null", None), ("true", True), ("FALSE", False), ("yes", "yes"),
        ("off", "off"), ("12", 12), ("-0.5", -0.5), ("1e3", 1000.0), (".5", 0.5), ("1:30", "1:30"),
        ("010", 10), ("0x10", "0x10"), ("2011-02-03", "2011-02-03"), ("'12'", "12"),
        (".nan", ".nan"),        (".inf", ".inf"), ("1_000", "1_000"),
    ],
)  # fmt: skip
def test_scalars_are_those_of_the_core_schema(text, value):
    found = parse(f"x: {text}").value["x"]
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(
    ("text", "where", "what"),
    [
        ("a: [1\nb: 2", "x.yaml:2:2", "not YAML"),
        ("a: 1\nb: 'x\n", "x.yaml:3:1", "not YAML"),
        ("a: 1\na: 2", "x.yaml:2:1: a", "given twice"),
        ("a: &x 1\nb: [*x]", "x.yaml:2:5: b[0]", "aliases"),
        ("a: !!python/none x", "x.yaml:1:4: a", "tag"),
        ("? [1]\n: 2", "x.yaml:1:3", "key"),
        ("a: 1e999", "x.yaml:1:4: a", "too large"),
        ("a: 1\n--- 2", "x.yaml:2:1", "second document"),
        ("a: \x00", "x.yaml:1:4", "NUL"),
        ("a: 1\nb: x\x0by", "x.yaml:2:5", "not YAML"),
        ("a: x\u2028y\nb: z\x85w\nc: c: c", "x.yaml:3:5", "not YAML"),
    ],
)
def test_what_is_refused(text, where, what):
    with pytest.raises(FormatError, match=what) as caught:
        parse(text)
    assert caught.value.where == where


def test_other_bytes_are_refused():
    with pytest.raises(FormatError, match="UTF-8"):
        parse_document(b"a: \xff", "x.yaml")


def test_deep_nesting_is_refused():
    with pytest.raises(FormatError):
        parse("[" * 100_000)


def test_an_empty_document_is_none():
    assert parse("# nothing").value is None


def test_a_missing_file_is_told(tmp_path):
    with pytest.raises(FormatError, match="can't be read"):
        read_document(tmp_path / "x.yaml")


@pytest.mark.parametrize(
    ("field", "where"),
    [
        (("items", "one", "at", 0), "x.yaml:3:14: items.one.at[0]"),
        (("items", "one", "at"), "x.yaml:3:13: items.one.at"),
        (("items", "one", "size"), "x.yaml:3:3: items.one.size"),
        (("title",), "x.yaml:1:8: title"),
        ((), "x.yaml:1:1"),
    ],
)
def test_problems_are_told_at_the_nearest_line(field, where):
    assert parse(TEXT).error(Problem(field, "wrong", "mend it")).where == where


@given(st.text())
def test_any_text_is_read_or_refused(text):
    with suppress(FormatError):
        assert parse(text).name == "x.yaml"
