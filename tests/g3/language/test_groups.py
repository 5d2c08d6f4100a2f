"""How many things OBJECTs speak of."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from g3.language.discourse.groups import Group, group
from g3.language.lexicon.tables import WORDS
from g3.sdc.clauses import SDC, Span
from g3.sdc.sdc_notation import parse_brackets

GOLDEN = {
    "the pallet": Group("singular", 1),
    "it": Group("singular", 1),
    "them": Group("plural"),
    "the last one": Group("singular", 1, "", (-1,)),
    "the empty ones": Group("plural"),
    "tires": Group("plural"),
    "the glass": Group("singular", 1),
    "both pallets": Group("plural", 2, "both"),
    "all the tires": Group("plural", None, "all"),
    "all": Group("plural", None, "all"),
    "each crate": Group("singular", 1, "each"),
    "some boxes": Group("plural", None, "some"),
    "two tire pallets": Group("plural", 2),
    "the other two trucks": Group("plural", 2),
    "12 boxes": Group("plural", 12),
    "the three": Group("plural", 3),
    "truck 2": Group("singular", 1),
    "the second pallet": Group("singular", 1, "", (2,)),
    "the first and second pallets": Group("plural", 2, "", (1, 2)),
    "the 1st and last pallet": Group("plural", 2, "", (1, -1)),
    "the last two crates": Group("plural", 2, "", (-1,)),
    "the tire pallet and the crate": Group("plural"),
    "the row": Group("plural", None, "", (), "row"),
}


@pytest.mark.parametrize("text", GOLDEN)
def test_leaves(text):
    (sdc,) = parse_brackets(f"OBJ(f = {text})", command=text)
    assert group(sdc) == GOLDEN[text]


@pytest.mark.parametrize(
    ("text", "notation", "expected"),
    [
        (
            "the row of pallets on the left",
            "OBJ(f = OBJ(f = OBJ(f = the row), r = of, l = OBJ(f = pallets)), r = on the left)",
            Group("plural", None, "", (), "row"),
        ),
        (
            "the row of three pallets",
            "OBJ(f = OBJ(f = the row), r = of, l = OBJ(f = three pallets))",
            Group("plural", 3, "", (), "row"),
        ),
        (
            "the pair of tire pallets",
            "OBJ(f = OBJ(f = the pair), r = of, l = OBJ(f = tire pallets))",
            Group("plural", 2, "", (), "pair"),
        ),
        (
            "the pallet of tires",
            "OBJ(f = OBJ(f = the pallet), r = of, l = OBJ(f = tires))",
            Group("singular", 1),
        ),
        (
            "one of the pallets",
            "OBJ(f = OBJ(f = one), r = of, l = OBJ(f = the pallets))",
            Group("singular", 1),
        ),
        (
            "all of the pallets",
            "OBJ(f = OBJ(f = all), r = of, l = OBJ(f = the pallets))",
            Group("plural", None, "all"),
        ),
    ],
)
def test_objects_with_modifiers(text, notation, expected):
    (sdc,) = parse_brackets(notation, command=text)
    assert group(sdc) == expected


LIKELY = "the a and all both one two 7 first last pallets crate of"
words = st.sampled_from([*LIKELY.split(), *sorted(WORDS["collectives"])])


@given(st.lists(words, max_size=8))
def test_any_words_have_a_number(found):
    spans = tuple(Span(10 * i, word) for i, word in enumerate(found))
    result = group(SDC("OBJECT", spans))
    assert result.number in ("singular", "plural")
    assert result.count is None or result.count >= 0
    assert result.quantifier == "" or result.quantifier in found
