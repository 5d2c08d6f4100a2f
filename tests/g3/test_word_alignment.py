from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from g3.errors import SDCError
from g3.word_alignment import FieldWord, align_words


def starts(command: str, *fields: str) -> list[list[int]]:
    placed = align_words([[FieldWord(word) for word in field.split()] for field in fields], command)
    return [[span.start for span in spans] for spans in placed]


def test_fields_take_different_words():
    command = "the pallet by the pallet"
    assert starts(command, "the pallet", "by", "the pallet") == [[0, 4], [11], [14, 18]]


def test_words_of_a_field_stay_together_where_they_can():
    assert starts("the big tire and the truck", "the truck") == [[17, 21]]


def test_a_field_may_have_gaps():
    assert starts("Put the tire pallet down", "Put down", "the tire pallet") == [
        [0, 20],
        [4, 8, 13],
    ]


def test_whole_words_come_first():
    assert starts("other the", "the") == [[6]]
    assert starts("cannot", "can", "not") == [[0], [3]]


def test_punctuation_ends_a_word():
    assert starts("lift it, then drop it.", "it", "it") == [[5], [19]]


def test_words_may_share_a_place_if_there_is_no_other():
    assert starts("it", "it", "it") == [[0], [0]]


def test_given_positions_are_kept_and_taken():
    placed = align_words([[FieldWord("it")], [FieldWord("it", 0)]], "it it")
    assert [spans[0].start for spans in placed] == [3, 0]


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ([[FieldWord("truck", where="column 9")]], "column 9: the word 'truck' is not in the co"),
        ([[FieldWord("pallet"), FieldWord("the")]], "the word 'the' doesn't stand after"),
        ([[FieldWord("pallet", 3)]], "the command doesn't have the word 'pallet' at position 3"),
    ],
)
def test_words_that_do_not_fit_are_named(fields, message):
    with pytest.raises(SDCError) as caught:
        align_words(fields, "the pallet")
    assert str(caught.value).startswith(message)


@given(st.lists(st.text("abc", min_size=1), unique=True, min_size=1), st.data())
def test_unique_words_are_found_where_they_are(words, data):
    command = " ".join(words)
    field_of = [data.draw(st.integers(0, 2)) for _ in words]
    fields = [[w for w, f in zip(words, field_of, strict=True) if f == i] for i in range(3)]
    placed = align_words([[FieldWord(w) for w in field] for field in fields], command)
    found = sorted(span for spans in placed for span in spans)
    assert [span.text for span in found] == words
    assert all(command[span.start : span.end] == span.text for span in found)
