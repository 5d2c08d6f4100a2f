"""Clauses that say what must not be."""

from __future__ import annotations

import pytest

from g3.language.discourse.negation import negated
from g3.sdc.clauses import breadth_first
from g3.sdc.sdc_notation import parse_brackets


def clauses(text, notation):
    return parse_brackets(notation, command=text)


@pytest.mark.parametrize(
    "relation",
    [
        "Don't lift",
        "Do n't lift",
        "don’t lift",
        "dont lift",
        "Do not lift",
        "Never lift",
        "must not lift",
        "without lifting",
        "cannot lift",
        "NOT",
    ],
)
def test_negated_relations(relation):
    text = f"{relation} it"
    (sdc,) = clauses(text, f"EVENT(r = {relation}, l = OBJ(f = it))")
    assert negated(sdc)


@pytest.mark.parametrize("relation", ["lift", "knot", "not only lift", "Note", "want"])
def test_others(relation):
    (sdc,) = clauses(f"{relation} it", f"EVENT(r = {relation}, l = OBJ(f = it))")
    assert not negated(sdc)


def test_only_the_clause_itself_is_negated():
    text = "Don't touch the crate on the truck and stop"
    sdcs = clauses(
        text,
        "EVENT(r = Don't touch, l = OBJ(f = OBJ(f = the crate), r = on, l = OBJ(f = the truck)))\n"
        "EVENT(r = stop)",
    )
    found = [negated(sdc, text) for sdc in breadth_first(sdcs)]
    assert found == [True] + [False] * (len(found) - 1)


def test_a_modifier_can_be_negated():
    text = "Lift the pallet that is not on the truck"
    (sdc,) = clauses(
        text,
        "EVENT(r = Lift, l = OBJ(f = OBJ(f = the pallet), r = that is not on, "
        "l = OBJ(f = the truck)))",
    )
    assert not negated(sdc)
    assert negated(sdc.landmark1[0])


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("Never lift it", True),
        ("please do not ever lift it", True),
        ("you mustn’t lift it", True),
        ("Do it now, not later. lift it", False),
        ("knot lift it", False),
    ],
)
def test_a_negation_that_the_tree_left_out(text, expected):
    sdcs = clauses(text, "EVENT(r = lift)")
    assert negated(sdcs[0], text) is expected
    assert not negated(sdcs[0])


def test_nothing_before_a_verb_negates_it():
    (sdc,) = parse_brackets("EVENT(r = nothing to lift)")
    assert negated(sdc)
    (sdc,) = parse_brackets("OBJ(f = OBJ(f = the truck), r = with nothing on, l = OBJ(f = it))")
    assert not negated(sdc)
