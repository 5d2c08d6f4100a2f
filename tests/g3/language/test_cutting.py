"""Cutting of texts into words."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from g3.language.parsing.words import MAX_WORDS, cut
from g3.lengths import MAX_CHARACTERS


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Don't lift it.", ["Don't", "lift", "it", "."]),
        ("go 1.5 m, then wait", ["go", "1.5", "m", ",", "then", "wait"]),
        ("T-shaped crate/box", ["T", "-", "shaped", "crate", "/", "box"]),
        ("the man’s_crate", ["the", "man’s", "_", "crate"]),
        ("", []),
    ],
)
def test_words(text, words):
    assert [span.text for span in cut(text).spans] == words


@given(st.text(max_size=80))
def test_nothing_but_white_space_is_left_out(text):
    spans = cut(text).spans
    assert all(text[span.start : span.end] == span.text for span in spans)
    kept = {i for span in spans for i in range(span.start, span.end)}
    assert not any(text[i].isalnum() for i in range(len(text)) if i not in kept)


def test_long_texts_are_cut_with_a_note():
    assert len(cut("it " * (MAX_WORDS + 5)).spans) == MAX_WORDS
    assert f"first {MAX_WORDS}" in cut("it " * (MAX_WORDS + 5)).note
    assert cut("it " * MAX_WORDS).note == ""
    assert cut("x" * (MAX_CHARACTERS + 1)).spans == ()
    assert cut("x" * (MAX_CHARACTERS + 1)).note
