"""Extractors that have learned from no command of a scenario."""

import pytest

pytest.importorskip("spacy")

from corpus_tools.corpus.annotated_trees import annotated_trees
from corpus_tools.importers.authored.bundled import open_corpus
from eval.parsing.sdc_scores import seen_scenarios
from eval.table_3.held_out import parser_without
from g3.language.parsing.parser import parse
from tests.eval.yard import few_annotated


def part(*names):
    commands = open_corpus("warehouse").commands.values()
    return few_annotated({c.id for c in commands if c.scenario in names}, "part")


@pytest.mark.slow
def test_the_scenario_that_is_left_out_teaches_nothing():
    one, other, third = "dock_pick_up_tires", "hall_pick_up_boxes", "hall_put_tires_in_storage"
    tested = annotated_trees(part(one, other, third))
    # Of the first corpus nothing is left.
    without = parser_without([part(one), part(other, third)])
    extractor = without(one)
    assert seen_scenarios(extractor, tested) == [other, third]
    assert parse("Pick up the boxes", extractor=extractor).sdcs
    assert without(one) is extractor
