"""Trees of clauses without a verb, and of sentences in steps."""

from __future__ import annotations

import pytest

from g3.language.parsing.parser import parse
from g3.sdc.clauses import all_words
from g3.sdc.sdc_notation import format_brackets, parse_brackets


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
