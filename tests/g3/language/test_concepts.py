from __future__ import annotations

import pytest

from g3.language.lexicon.concepts import CONCEPTS, concepts
from g3.language.lexicon.field_words import normalise


def of(phrase: str) -> set[str]:
    return set(concepts(map(normalise, phrase.split())))


@pytest.mark.parametrize(
    ("phrase", "named"),
    [
        ("to the left of", {"to", "left"}),
        ("leftmost", {"left"}),
        ("Right-hand side", {"right", "near"}),
        ("in front of", {"front"}),
        ("forwards", {"front"}),
        ("behind", {"back"}),
        ("reverse", {"back"}),
        ("on top of", {"on"}),
        ("onto", {"on", "to"}),
        ("between", {"between"}),
        ("next to", {"near", "to"}),
        ("beside", {"near"}),
        ("the nearest", {"near", "first"}),
        ("furthest", {"far", "last"}),
        ("away from", {"from"}),
        ("towards", {"to"}),
        ("approaching", {"to"}),
        ("the tire pallet", set()),
        ("", set()),
    ],
)
def test_concepts_of_phrases(phrase: str, named: set[str]) -> None:
    assert of(phrase) == named


def test_every_concept_has_a_word() -> None:
    examples = "left right front back on between near far to from first last".split()  # noqa: SIM905
    assert set(examples) == set(CONCEPTS)
    for word in examples:
        assert word in of(word)
