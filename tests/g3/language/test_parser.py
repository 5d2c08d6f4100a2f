"""Commands to trees with the parser that comes along."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import g3
from g3.errors import CorpusError
from g3.language.parsing.parser import LEAST_LIKELY, SURE, parse, parse_many, parse_unsure
from g3.language.parsing.words import MAX_WORDS
from g3.sdc.clauses import breadth_first
from g3.sdc.sdc_notation import check_sdc, format_brackets, parse_brackets

GOLDEN = {
    "Put the pallet on the truck.": (
        "EVENT(r = Put, l = OBJ(f = the pallet), l2 = PLACE(r = on, l = OBJ(f = the truck)))"
    ),
    "Go to the pallet on the truck.": (
        "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = OBJ(f = the pallet), r = on, "
        "l = OBJ(f = the truck))))"
    ),
    "Put the tire pallet down": "EVENT(r = Put down, l = OBJ(f = the tire pallet))",
    "pick the pallet up": "EVENT(r = pick up, l = OBJ(f = the pallet))",
    "Pick up the tire pallet off the truck and set it down": (
        "EVENT(r = Pick up, l = OBJ(f = the tire pallet), l2 = PATH(r = off, "
        "l = OBJ(f = the truck)))\nEVENT(r = set down, l = OBJ(f = it))"
    ),
    "PUT THE PALLET ON THE TRUCK": (
        "EVENT(r = PUT, l = OBJ(f = THE PALLET), l2 = PLACE(r = ON, l = OBJ(f = THE TRUCK)))"
    ),
    "take the tyre palette off the tailor": (
        "EVENT(r = take, l = OBJ(f = the tyre palette), l2 = PATH(r = off, "
        "l = OBJ(f = the tailor)))"
    ),
    "pick up the palllet of boxes": (
        "EVENT(r = pick up, l = OBJ(f = OBJ(f = the palllet), r = of, l = OBJ(f = boxes)))"
    ),
    "Lift the second pallet from the left": (
        "EVENT(r = Lift, l = OBJ(f = OBJ(f = the second pallet), r = from the left))"
    ),
    "Lift the last pallet of tires on the right": (
        "EVENT(r = Lift, l = OBJ(f = OBJ(f = OBJ(f = the last pallet), r = of, "
        "l = OBJ(f = tires)), r = on the right))"
    ),
    "set the largest crate between the truck and the trailer": (
        "EVENT(r = set, l = OBJ(f = the largest crate), l2 = PLACE(r = between, "
        "l = OBJ(f = the truck), l2 = OBJ(f = the trailer)))"
    ),
    "Take the boxes and the tires to the trailer.": (
        "EVENT(r = Take, l = [OBJ(f = the boxes), OBJ(f = the tires)], l2 = PATH(r = to, "
        "l = OBJ(f = the trailer)))"
    ),
    "Pick up the pallet that is closest to the truck": (
        "EVENT(r = Pick up, l = OBJ(f = OBJ(f = the pallet), r = that is closest to, "
        "l = OBJ(f = the truck)))"
    ),
    "Go to the truck. Turn left. Drop it there.": (
        "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the truck)))\nEVENT(r = Turn left)\n"
        "EVENT(r = Drop, l = OBJ(f = it), l2 = PLACE(r = there))"
    ),
    "go to the truck, then pick it up and wait": (
        "EVENT(r = go, l = PATH(r = to, l = OBJ(f = the truck)))\n"
        "EVENT(r = pick up, l = OBJ(f = it))\nEVENT(r = wait)"
    ),
    "Don't move the trailer.": "EVENT(r = Don't move, l = OBJ(f = the trailer))",
    "Could you move the pallet to receiving?": (
        "EVENT(r = move, l = OBJ(f = the pallet), l2 = PATH(r = to, l = OBJ(f = receiving)))"
    ),
    "the pallet on the left": "EVENT(l = OBJ(f = OBJ(f = the pallet), r = on the left))",
    "hoist the skid and wheel it over to the dock": (
        "EVENT(r = hoist, l = OBJ(f = the skid))\n"
        "EVENT(r = wheel, l = OBJ(f = it), l2 = PATH(r = over to, l = OBJ(f = the dock)))"
    ),
    "Lift all the tires": "EVENT(r = Lift, l = OBJ(f = all the tires))",
    "pick up all of the crates": (
        "EVENT(r = pick up, l = OBJ(f = OBJ(f = all), r = of, l = OBJ(f = the crates)))"
    ),
    "lift the first and second pallets": (
        "EVENT(r = lift, l = OBJ(f = the first and second pallets))"
    ),
    "Take the row of pallets": (
        "EVENT(r = Take, l = OBJ(f = OBJ(f = the row), r = of, l = OBJ(f = pallets)))"
    ),
    "Never touch the truck": "EVENT(r = Never touch, l = OBJ(f = the truck))",
    "don’t lift the crate": "EVENT(r = don’t lift, l = OBJ(f = the crate))",
    "drive past the truck without touching it": (
        "EVENT(r = drive, l = PATH(r = past, l = OBJ(f = the truck)))\n"
        "EVENT(r = without touching, l = OBJ(f = it))"
    ),
    "carry them to the far end of the warehouse, past the barrel": (
        "EVENT(r = carry, l = OBJ(f = them), l2 = [PATH(r = to the far end of, "
        "l = OBJ(f = the warehouse)), PATH(r = past, l = OBJ(f = the barrel))])"
    ),
}


MISREAD = "Lift the last pallet of tires on the right"
"""It takes the tires to be on the right, not the pallet; the right tree is its second one."""


@pytest.mark.parametrize("text", [text for text in GOLDEN if text != MISREAD])
def test_golden_trees(text):
    gold = parse_brackets(GOLDEN[text], command=text)
    assert format_brackets(parse(text).sdcs) == format_brackets(gold)


def test_a_golden_tree_is_among_the_two_most_probable():
    gold = format_brackets(parse_brackets(GOLDEN[MISREAD], command=MISREAD))
    assert gold in [format_brackets(tree.sdcs) for tree in parse(MISREAD, n_best=2)]


def test_the_package_has_the_function():
    assert g3.parse("Wait.") == parse("Wait.")


def test_until_holds_a_clause():
    (sdc,) = parse("drive forward until you reach the wall").sdcs
    inner = [clause for clause in breadth_first([sdc]) if clause.type == "EVENT"][1:]
    assert inner
    assert any(word.text == "until" for clause in inner for word in clause.relation)


def check(parsed, n_best):
    assert len(parsed.trees) <= n_best
    chances = [tree.probability for tree in parsed.trees]
    assert chances == sorted(chances, reverse=True)
    assert all(0 <= chance <= 1 for chance in chances)
    assert math.fsum(chances) <= 1 + 1e-6
    assert len({tree.sdcs for tree in parsed.trees}) == len(parsed.trees)
    assert parsed.note or parsed.trees
    for tree in parsed.trees:
        for sdc in tree.sdcs:
            check_sdc(sdc)
        spans = [span for sdc in breadth_first(tree.sdcs) for span in (*sdc.words, *sdc.relation)]
        assert all(parsed.text[span.start : span.end] == span.text for span in spans)
        assert len({span.start for span in spans}) == len(spans)


LIKELY = (
    "put the pallet on truck and then pick up it of between you see that is until to left right "
    ", . tires from don't with 😀 ß ; - 3 ' \" there"
)
vocabulary = st.sampled_from(LIKELY.split())


@given(st.lists(vocabulary, max_size=25).map(" ".join), st.integers(1, 6))
def test_sentences_of_likely_words_are_parsed(text, n_best):
    check(parse(text, n_best=n_best), n_best)


@given(st.text(max_size=60))
def test_any_text_is_parsed_or_has_a_reason(text):
    check(parse(text), 1)


ALPHABETS = (
    "abcdefghijklmnopqrstuvwxyz      ",
    "😀🚚📦🏗️ \u200d",
    "托盘放在卡车上。 ",
    "ضع المنصة على الشاحنة ",
    "\x00\t\r\n \ud800\uffff\u202e",
    " .,;:!?'\"()[]{}-–_/\\<>&%$#@*+=0123456789",
)


@pytest.mark.slow
def test_random_texts():
    rng = np.random.default_rng(5)
    vocabulary = [*LIKELY.split(), "Don't", "the", "all", "of", "it"]

    def text(number):
        kind, size = number % (len(ALPHABETS) + 2), min(int(rng.exponential(7)), 60)
        if kind < len(ALPHABETS):
            return "".join(rng.choice(list(ALPHABETS[kind]), 2 * size))
        if kind == len(ALPHABETS):
            return " ".join(rng.choice(vocabulary, size))
        return "".join(map(chr, rng.integers(0, 0x110000, size)))

    texts = [text(number) for number in range(1500)]
    for parsed in parse_many(texts):
        check(parsed, 1)
    for parsed in parse_many(texts[:200], n_best=4):
        check(parsed, 4)


@pytest.mark.parametrize(
    "text",
    [
        "",
        " \n\t",
        "\x00",
        "\ud800 lift it",
        "😀" * 200,
        "of " * 5000,
        "(" * 1000,
        "put the crate on the truck " * 400,
        "until you see it " * 200,
        "that is " * 300,
        "x" * 10_000,
        "把托盘放在卡车上",
        "Stell die Palette auf den Lastwagen",
        "ضع المنصة على الشاحنة",
        "a\u2028b\u0085c\u00a0d\u200be",
    ],
)
def test_odd_texts(text):
    for n_best in (1, 3):
        check(parse(text, n_best=n_best), n_best)


def test_what_is_left_out_is_said():
    assert parse("").note == "the text has no words"
    assert parse("!").trees == () or not parse("!").note
    parsed = parse("lift it " * MAX_WORDS)
    assert parsed.note == f"only the first {MAX_WORDS} words were parsed, which is the limit"
    assert parsed.trees


@pytest.mark.parametrize("piece", ["(", "😀", "a ", "\u0301", "lift it ", "\0"])
def test_nothing_of_a_text_that_is_too_long_is_looked_at(piece):
    parsed = parse(piece * (100_000 // len(piece)))
    assert parsed.trees == ()
    assert parsed.note == "the text has 100000 characters, the limit is 4000"


def test_the_best_tree_does_not_depend_on_how_many_are_asked_for():
    texts = list(GOLDEN)
    for one, several in zip(parse_many(texts), parse_many(texts, n_best=5), strict=True):
        assert one.sdcs == several.sdcs
        assert one.trees[0].probability == pytest.approx(several.trees[0].probability, rel=1e-4)


def test_many_commands_give_what_each_gives_alone():
    texts = [*GOLDEN, "", *GOLDEN]
    together = list(parse_many(texts))
    assert [p.text for p in together] == texts
    assert [p.sdcs for p in together[:5]] == [parse(text).sdcs for text in texts[:5]]
    assert together == list(parse_many(texts))


def test_no_trees_can_not_be_asked_for():
    with pytest.raises(CorpusError, match="at least one"):
        parse("lift it", n_best=0)


def test_more_trees_are_given_only_where_the_best_one_is_not_sure():
    counts = set()
    for text in GOLDEN:
        several = parse_unsure(text, n_best=4).trees
        alone = parse(text)
        best = several[0]
        assert (best.sdcs, len(parse_unsure(text, n_best=1).trees)) == (alone.sdcs, 1)
        if alone.trees[0].probability >= SURE:
            assert len(several) == 1
        counts.add(len(several))
        assert all(tree.probability >= LEAST_LIKELY * best.probability for tree in several)
    assert parse_unsure("", n_best=3).trees == ()
    assert max(counts) > 1
