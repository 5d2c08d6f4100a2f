from __future__ import annotations

from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from g3.errors import SDCError
from g3.sdc.word_alignment import FieldWord, align_words


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


def test_of_a_repeated_word_a_field_has_the_copy_beside_the_field_before_it():
    command = "it is in the way, so put it in the back"
    assert starts(command, "put", "it", "in", "the back") == [[21], [25], [28], [31, 35]]


@given(st.lists(st.sampled_from(["lift", "it", "by", "the", "crate"]), min_size=1, max_size=4))
def test_a_clause_said_again_is_placed_whole(fields):
    words = list(dict.fromkeys(fields))
    command = " ".join(["first", *words, "and", "then", *words, "last"])
    after = command.index("then")
    placed = starts(command, "then", *words)
    assert [place for (place,) in placed[1:]] == [
        command.index(f" {word}", after) + 1 for word in words
    ]


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


def by_trying_all(words: list[str], command: str) -> list[int] | None:
    """The best placement of a field by the docstring's rules, among all."""
    places = [[i for i in range(len(command)) if command.startswith(w, i)] for w in words]
    found = []
    for chosen in product(*places):
        ends = [start + len(word) for start, word in zip(chosen, words, strict=True)]
        between = [command[end:start] for end, start in pairwise_gaps(chosen, ends)]
        if any(end > start for end, start in pairwise_gaps(chosen, ends)):
            continue
        cut = sum(
            any(0 < i < len(command) and command[i - 1 : i + 1].isalnum() for i in (start, end))
            for start, end in zip(chosen, ends, strict=True)
        )
        found.append((cut, sum(bool(text.strip()) for text in between), list(chosen)))
    return min(found)[-1] if found else None


def pairwise_gaps(chosen: tuple[int, ...], ends: list[int]) -> list[tuple[int, int]]:
    return list(zip(ends[:-1], chosen[1:], strict=True))


@given(
    st.lists(st.sampled_from(["a", "b", "ab", "aa", "-"]), min_size=1, max_size=3),
    st.text("ab -", max_size=12),
)
def test_the_best_of_all_placements_is_found(words, command):
    expected = by_trying_all(words, command)
    if expected is None:
        with pytest.raises(SDCError):
            align_words([[FieldWord(word) for word in words]], command)
    else:
        assert starts(command, " ".join(words)) == [expected]


def test_many_occurrences_take_bounded_time():
    """Of 60 words that stand everywhere; all pairs of places would be half a billion."""
    spans = starts("a" * 4000, " ".join("a" * 60))[0]
    assert spans == list(range(60))


def test_a_command_that_is_too_long_is_refused_at_once():
    with pytest.raises(SDCError, match="the text has 100000 characters, the limit is 4000"):
        align_words([[FieldWord("a")] * 1000], "a" * 100_000)


@given(st.lists(st.text("abc", min_size=1), unique=True, min_size=1), st.data())
def test_unique_words_are_found_where_they_are(words, data):
    command = " ".join(words)
    field_of = [data.draw(st.integers(0, 2)) for _ in words]
    fields = [[w for w, f in zip(words, field_of, strict=True) if f == i] for i in range(3)]
    placed = align_words([[FieldWord(w) for w in field] for field in fields], command)
    found = sorted(span for spans in placed for span in spans)
    assert [span.text for span in found] == words
    assert all(command[span.start : span.end] == span.text for span in found)
