"""Scores of extracted trees, worked by hand."""

from __future__ import annotations

from eval.parsing.sdc_scores import Counts, compare
from g3.sdc.sdc_notation import parse_brackets

TEXT = "Put the pallet on the truck. Wait."
GOLD = (
    "EVENT(r = Put, l = OBJ(f = the pallet), l2 = PLACE(r = on, l = OBJ(f = the truck)))\n"
    "EVENT(r = Wait)"
)


def trees(notation, text=TEXT):
    return parse_brackets(notation, command=text)


def test_the_same_trees():
    found = compare(trees(GOLD), trees(GOLD), TEXT)
    assert found.typed == found.untyped == Counts(5, 5, 5)
    assert found.segments == Counts(2, 2, 2)
    assert found.exact
    assert found.by_type == {
        "EVENT": Counts(2, 2, 2),
        "OBJECT": Counts(2, 2, 2),
        "PLACE": Counts(1, 1, 1),
        "PATH": Counts(0, 0, 0),
    }
    assert found.confusion == {
        ("EVENT.r", "EVENT.r"): 7,
        ("OBJECT.f", "OBJECT.f"): 17,
        ("PLACE.r", "PLACE.r"): 2,
    }


def test_a_wrong_type_counts_for_typed_only():
    found = compare(trees(GOLD.replace("PLACE", "PATH")), trees(GOLD), TEXT)
    assert (found.typed, found.untyped) == (Counts(4, 5, 5), Counts(5, 5, 5))
    assert found.confusion["PLACE.r", "PATH.r"] == 2
    assert not found.exact


def test_a_wrong_attachment():
    attached = (
        "EVENT(r = Put, l = OBJ(f = OBJ(f = the pallet), r = on, l = OBJ(f = the truck)))\n"
        "EVENT(r = Wait)"
    )
    found = compare(trees(attached), trees(GOLD), TEXT)
    # Wrong: the OBJECT of five words; missing: the PLACE.
    assert (found.typed, found.untyped) == (Counts(4, 5, 5), Counts(4, 5, 5))
    assert found.segments == Counts(2, 2, 2)


def test_clauses_run_together():
    together = (
        "EVENT(r = Put Wait, l = OBJ(f = the pallet), l2 = PLACE(r = on, l = OBJ(f = the truck)))"
    )
    found = compare(trees(together), trees(GOLD), TEXT)
    assert found.typed == Counts(3, 4, 5)
    assert found.segments == Counts(0, 1, 2)


def test_words_that_one_side_leaves_out_do_not_move_segments():
    text = "then lift it, wait"
    found = compare(
        trees("EVENT(r = then lift, l = OBJ(f = it)); EVENT(r = wait)", text),
        trees("EVENT(r = lift, l = OBJ(f = it)); EVENT(r = wait)", text),
        text,
    )
    assert found.segments == Counts(2, 2, 2)
    assert found.typed == Counts(2, 3, 3)


def test_punctuation_and_the_cut_of_words_do_not_count():
    text = "Take the left-most pallet."
    one = trees("EVENT(r = Take, l = OBJ(f = the left-most pallet.))", text)
    other = trees("EVENT(r = Take, l = OBJ(f = the left - most pallet))", text)
    assert compare(one, other, text).exact


def test_nothing_extracted():
    found = compare((), trees(GOLD), TEXT)
    assert found.typed == Counts(0, 0, 5)
    assert found.typed.precision.reason == "empty class"
    assert (found.typed.recall.value, found.typed.f.value) == (0, 0)
    assert not found.exact
    assert found.confusion == {("EVENT.r", "-"): 7, ("OBJECT.f", "-"): 17, ("PLACE.r", "-"): 2}


def test_nothing_on_either_side():
    found = compare((), (), "")
    assert found.typed.f.reason == "empty class"
    assert found.exact


def test_figures_of_counts():
    counts = Counts(3, 4, 6) + Counts(0, 1, 0)
    assert (counts.precision.value, counts.recall.value) == (3 / 5, 1 / 2)
    assert counts.f.value == 2 * 3 / 11
