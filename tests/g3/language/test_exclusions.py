"""What texts rule out, whatever their trees have made of it."""

import pytest

from benchmarks.ruled_out import commands, handled
from g3.inference.grounder import Grounder
from g3.language.discourse.exclusions import exclusions
from g3.language.lexicon.tables import members
from g3.language.parsing.words import cut
from tests.g3.inference.constant_cost import ConstantCost


def nouns(text):
    return [" ".join(word.text for word in noun) for noun in exclusions(cut(text).spans)]


@pytest.mark.parametrize("example", [row.example for row in members("cue").values()])
def test_each_cue_rules_out_its_noun(example):
    assert any("crate" in noun or "far ones" in noun for noun in nouns(example))


@pytest.mark.parametrize(
    ("text", "noun"),
    [
        ("Don't you dare move the crate and take the boxes", "the crate"),
        ("The fridge is not to be touched by anyone, lift the crate", "The fridge"),
        ("I don't want the left tires moved", "the left tires"),
        ("all the loads to the truck, not the crate though", "the crate though"),
    ],
)
def test_negated_words_rule_out_their_noun(text, noun):
    assert noun in nouns(text)


@pytest.mark.parametrize(
    "text",
    [
        "Why don't you lift the crate",
        "Don't forget the crate",
        "Lift not only the crate",
        "Tires are not to be left on the flatbed",
        "Lift the crate that is not on the truck",
        "No, the crate",
        "Stay where you are",
        "Don't stop until you reach the crate",
    ],
)
def test_what_is_wanted_is_not_ruled_out(text):
    assert nouns(text) == []


def test_what_is_ruled_out_is_never_handled():
    grounder = Grounder(ConstantCost())
    told = [(c.text, done) for c in commands(30, 1) if (done := handled(grounder, c))]
    assert told == []
