"""Clauses without a verb, and words that only say that a step follows."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from g3.language.parsing.clauses_without_verb import apart
from g3.language.parsing.parser import parse
from g3.language.parsing.step_words import without_step_words
from g3.sdc.clauses import all_words
from g3.sdc.sdc_notation import format_brackets, parse_brackets


def tokens(text):
    """Words with their places, cut at white space."""
    return [(m.start(), m.end(), m.group()) for m in re.finditer(r"\S+", text)]


def read(found):
    return " ".join(word for _, _, word in found)


@pytest.mark.parametrize(
    ("text", "told", "clauses"),
    [
        ("tires to truck", "tires to truck", 1),
        ("tires to it and the boxes onto it too", "tires to it . the boxes onto it", 2),
        ("lift it , then crates on the truck", "lift it . crates on the truck", 1),
        ("crates to the gate , then lift it", "crates to the gate . then lift it", 1),
        ("tires on the right to the truck", "tires on the right to the truck", 1),
        # A verb, or no thing, or no goal.
        ("put tires on the truck , boxes on it", None, 0),
        ("to the truck", None, 0),
        ("the crate next to the truck", None, 0),
        ("the crate to the left of it", None, 0),
        ("the crate to the right", None, 0),
        ("", None, 0),
    ],
)
def test_clauses_without_a_verb_are_sentences(text, told, clauses):
    found, begins = apart(tokens(text))
    assert read(found) == (told if told is not None else text)
    assert len(begins) == clauses


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("drop it , and after that , lift it", "drop it . lift it"),
        ("drop it . When this is done lift it".lower(), "drop it . lift it"),
        ("afterwards lift it", "lift it"),
        ("drop it . once done , the crate goes there", "drop it . the crate goes there"),
        # What is waited for, and what is passed.
        ("when the truck is done lift it", None),
        ("after that truck turn left", None),
        ("turn left after that", None),
        ("lift it afterwards", None),
    ],
)
def test_words_that_say_that_a_step_follows_are_left_out(text, told):
    assert read(without_step_words(tokens(text))) == (told or text)


WORDS = "tires the crate to onto on truck , . and then after that this is done lift too left of it"


@given(st.lists(st.sampled_from(WORDS.split()), max_size=25).map(" ".join))
def test_words_stay_in_order_and_none_is_made_up(text):
    for found in (apart(tokens(text))[0], without_step_words(tokens(text))):
        assert all(word in (text[start:end].split()[0], ".") for start, end, word in found)
        assert [start for start, _, _ in found] == sorted(start for start, _, _ in found)


@pytest.mark.parametrize(
    ("text", "clauses"),
    [
        (
            "fridges to the trailer and crate -> truck",
            "OBJ(f = fridges)\nPATH(r = to, l = OBJ(f = the trailer))\n"
            "OBJ(f = crate)\nPATH(r = ->, l = OBJ(f = truck))",
        ),
        (
            "set it down, after that lift the crate",
            "EVENT(r = set down, l = OBJ(f = it))\nEVENT(r = lift, l = OBJ(f = the crate))",
        ),
    ],
)
def test_such_clauses_are_parsed(text, clauses):
    found = parse(text).sdcs
    assert format_brackets(found) == format_brackets(parse_brackets(clauses, command=text))
    assert all(text[w.start : w.end] == w.text for sdc in found for w in all_words(sdc))
