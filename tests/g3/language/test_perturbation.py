"""Commands as other people type them, and their trees."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from g3.errors import FormatError
from g3.language.parsing.perturbation import PERTURBATIONS, perturb
from g3.sdc.clauses import breadth_first
from g3.sdc.sdc_notation import check_sdc, parse_brackets

TEXT = "Pick up the pallet, then put it on the truck."
TREE = (
    "EVENT(r = Pick up, l = OBJ(f = the pallet))\n"
    "EVENT(r = then put, l = OBJ(f = it), l2 = PLACE(r = on, l = OBJ(f = the truck)))"
)
kinds = st.sampled_from(sorted(PERTURBATIONS))
LIKELY = "the The a an pallet pallets, truck. A 3 ß İ - don't on , . !"
words = st.sampled_from(LIKELY.split())
texts = st.one_of(st.text(max_size=40), st.lists(words, max_size=12).map(" ".join))


def trees():
    return parse_brackets(TREE, command=TEXT)


@pytest.mark.parametrize(
    ("kind", "text"),
    [
        ("articles", "Pick up pallet, then put it on truck."),
        ("capitals", "PICK UP THE PALLET, THEN PUT IT ON THE TRUCK."),
        ("run-on", "Pick up the pallet then put it on the truck"),
    ],
)
def test_what_is_typed_instead(kind, text):
    assert perturb(TEXT, kind).text == text


@pytest.mark.parametrize("text", ["Go to truck A.", "A", "lift the 3 crates", "then breathe"])
def test_what_is_no_article_stays(text):
    assert perturb(text, "articles").text == text


def test_a_typo_is_in_one_word_and_keeps_its_first_letter():
    for seed in range(50):
        typed = perturb(TEXT, "typos", seed=seed).text.split(" ")
        (wrong,) = [(a, b) for a, b in zip(TEXT.split(" "), typed, strict=True) if a != b]
        assert wrong[0][0] == wrong[1][0]
        assert abs(len(wrong[0]) - len(wrong[1])) <= 1
    assert len({perturb(TEXT, "typos", seed=seed).text for seed in range(50)}) > 10


def test_trees_keep_their_words():
    typed = perturb(TEXT, "articles", sdcs=trees())
    expected = (
        "EVENT(r = Pick up, l = OBJ(f = pallet))\n"
        "EVENT(r = then put, l = OBJ(f = it), l2 = PLACE(r = on, l = OBJ(f = truck)))"
    )
    assert typed.carry(trees()) == parse_brackets(expected, command=typed.text)


def test_a_word_that_is_all_of_a_field_is_never_left_out():
    text = "lift the or both"
    (sdc,) = parse_brackets("EVENT(r = lift, l = OBJ(f = the))", command=text)
    assert perturb(text, "articles").text == "lift or both"
    assert perturb(text, "articles", sdcs=[sdc]).carry([sdc]) == (sdc,)


@given(kinds, st.integers(0, 9))
def test_clauses_stay_the_same_clauses(kind, seed):
    typed = perturb(TEXT, kind, seed=seed, sdcs=trees())
    carried = typed.carry(trees())
    for before, after in zip(breadth_first(trees()), breadth_first(carried), strict=True):
        assert (before.type, before.is_implicit) == (after.type, after.is_implicit)
        for field in ("words", "relation"):
            spans = getattr(after, field)
            assert bool(spans) == bool(getattr(before, field))
            assert all(typed.text[s.start : s.end] == s.text for s in spans)
    for sdc in carried:
        check_sdc(sdc)


@given(texts, kinds, st.integers(0, 3))
def test_any_text_is_perturbed_and_each_time_in_the_same_way(text, kind, seed):
    typed = perturb(text, kind, seed=seed)
    assert typed == perturb(text, kind, seed=seed)
    assert len(typed.origin) == len(typed.text)
    assert list(typed.origin) == sorted(typed.origin)
    assert all(0 <= place < len(text) for place in typed.origin)


@given(texts, st.sampled_from(["articles", "run-on", "capitals"]))
def test_who_types_so_already_is_left_alone(text, kind):
    once = perturb(text, kind).text
    assert len(perturb(once, kind).text) <= len(once) or kind == "capitals"
    if kind == "capitals":
        assert perturb(once, kind).text == once


def test_a_kind_that_there_is_not():
    with pytest.raises(FormatError, match=r"no perturbation 'shouting'.*articles, typos"):
        perturb(TEXT, "shouting")
