from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eval.table_1.correspondence import TYPES, Predictions
from eval.table_1.error_lists import KINDS, Example, error_lists, render_lists

# type, label, probability, id, words, source
HAND = [
    ("OBJECT", True, 0.90, "a1.0", "the tire pallet", "positive"),
    ("OBJECT", True, 0.95, "a2.0", "The tire  pallet", "positive"),
    ("OBJECT", True, 0.95, "a3.0", "tires", "positive"),
    ("OBJECT", True, 0.60, "a4.0", "palette", "positive"),
    ("OBJECT", False, 0.10, "a5.0", "the tire pallet", "random"),
    ("OBJECT", True, 0.05, "a6.0", "the goods", "positive"),
    ("EVENT", False, 0.80, "a7.1", "move back", "random"),
]


def split(examples):
    kind, label, probability, ids, words, source = zip(*examples, strict=True) or [()] * 6
    ids_as_commands = np.array(ids)
    predictions = Predictions(
        np.array(kind), np.array(label), np.array(probability), ids_as_commands, ids_as_commands
    )
    return predictions, [Example(*one) for one in zip(ids, words, source, strict=True)]


def by_key(lists):
    return {(one.type, one.correct, one.scoring): one for one in lists}


def test_lists_worked_by_hand():
    lists = by_key(error_lists(*split(HAND), k=2))
    best = lists["OBJECT", True, "highest"]
    # Equal probabilities go by the alphabet; "palette" falls to k.
    assert [(p.words, p.probability, p.count, p.total, p.id) for p in best.phrases] == [
        ("the tire pallet", 0.95, 2, 3, "a2.0"),
        ("tires", 0.95, 1, 1, "a3.0"),
    ]
    assert best.examples == 4
    assert [p.id for p in lists["OBJECT", True, "lowest"].phrases] == ["a5.0"]
    assert [p.id for p in lists["OBJECT", False, "lowest"].phrases] == ["a6.0"]
    assert [p.words for p in lists["EVENT", False, "highest"].phrases] == ["move back"]
    assert lists["PLACE", False, "highest"].phrases == ()


def test_lists_come_type_by_type():
    keys = [(one.type, one.correct, one.scoring) for one in error_lists(*split(HAND))]
    assert keys == [(kind, *rest) for kind in TYPES for rest in KINDS]


def test_no_examples():
    nothing = Predictions([], [], [], [], [])
    assert all(one.phrases == () for one in error_lists(nothing, []))
    assert render_lists(error_lists(nothing, []), "text", {}).startswith("p: ")


def test_unaligned_examples_are_refused():
    predictions, examples = split(HAND)
    with pytest.raises(ValueError, match="6 examples for 7 predictions"):
        error_lists(predictions, examples[1:])


rows = st.lists(
    st.tuples(
        st.sampled_from(TYPES),
        st.booleans(),
        st.sampled_from([0.0, 0.2, 0.5, 0.7, 1.0]),
        st.sampled_from(["a", "b", "c"]),
        st.sampled_from(["on", "On", "to the truck", ""]),
        st.sampled_from(["positive", "random"]),
    ),
    min_size=1,
    max_size=30,
)


@given(rows, st.randoms(use_true_random=False))
def test_the_order_of_examples_does_not_matter(examples, random):
    shuffled = list(examples)
    random.shuffle(shuffled)
    assert error_lists(*split(examples), k=2) == error_lists(*split(shuffled), k=2)


@given(rows)
def test_every_example_is_in_one_list_and_phrases_are_in_order(examples):
    lists = error_lists(*split(examples), k=100)
    assert sum(one.examples for one in lists) == len(examples)
    for one in lists:
        assert sum(phrase.count for phrase in one.phrases) == one.examples
        assert len({phrase.words for phrase in one.phrases}) == len(one.phrases)
        scores = [phrase.probability for phrase in one.phrases]
        assert scores == sorted(scores, reverse=one.scoring == "highest")
        assert all(phrase.count <= phrase.total for phrase in one.phrases)


def test_json_has_lists_beside_metadata():
    read = json.loads(render_lists(error_lists(*split(HAND)), "json", {"seed": 1}))
    assert read["seed"] == 1
    assert read["lists"][0]["phrases"][0] == {
        "words": "the tire pallet",
        "probability": 0.95,
        "count": 2,
        "total": 3,
        "id": "a2.0",
        "source": "positive",
    }


def test_table_shows_only_lists_with_phrases():
    text = render_lists(error_lists(*split(HAND)), "text", {"seed": 1})
    assert text.isascii()
    assert "EVENT, incorrect, highest-scoring (phrases: 1, of 1 examples)" in text
    assert "PLACE" not in text
    assert "2 of 3" in text


def test_words_typed_by_people_cannot_drive_the_terminal():
    words = "\x1b[31mpick [bold]up"
    lists = error_lists(*split([("EVENT", True, 0.9, "a", words, "positive")]))
    text = render_lists(lists, "text", {}, terminal=True)
    assert "\x1b[31m" not in text
    assert "[31mpick [bold]up" in text


def test_unknown_format_is_refused():
    with pytest.raises(ValueError, match="expected one of text, json"):
        render_lists((), "csv", {})
