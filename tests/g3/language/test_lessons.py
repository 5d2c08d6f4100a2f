"""The hand-written trees."""

from __future__ import annotations

import pytest

from g3.language.parsing.training.lessons import written_trees
from g3.sdc.clauses import all_words
from g3.sdc.sdc_notation import check_sdc


@pytest.mark.parametrize(("text", "sdcs"), written_trees(), ids=lambda value: str(value)[:40])
def test_trees_are_well_formed(text, sdcs):
    for sdc in sdcs:
        check_sdc(sdc)
    inside = "".join(word.text for sdc in sdcs for word in all_words(sdc))
    letters = [letter for letter in text if letter.isalpha()]
    assert sum(map(str.isalpha, inside)) >= 0.2 * len(letters)


def test_no_command_is_there_twice():
    texts = [text.lower() for text, _ in written_trees()]
    assert len(set(texts)) == len(texts) > 30
