"""What pronouns can stand for."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from g3.language.discourse.anaphora import anaphors
from g3.language.parsing.parser import parse
from g3.sdc.clauses import all_words, breadth_first
from g3.sdc.sdc_notation import parse_brackets

LIFT_AND_SET = (
    "EVENT(r = Pick up, l = OBJ(f = the tire pallet), l2 = PATH(r = off, l = OBJ(f = the truck)))\n"
    "EVENT(r = set down, l = OBJ(f = it))"
)
GOLDEN = {
    "Pick up the tire pallet off the truck and set it down": (
        LIFT_AND_SET,
        [("it", "same", ["the tire pallet", "the truck"])],
    ),
    "Lift the crate, move it and drop it": (
        "EVENT(r = Lift, l = OBJ(f = the crate))\nEVENT(r = move, l = OBJ(f = it))\n"
        "EVENT(r = drop, l = OBJ(f = it))",
        [("it", "same", ["the crate"]), ("it", "same", ["it", "the crate"])],
    ),
    "Go to the truck with tires on it": (
        "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = OBJ(f = the truck), r = with, "
        "l = OBJ(f = OBJ(f = tires), r = on, l = OBJ(f = it)))))",
        [("it", "same", ["the truck with tires on it"])],
    ),
    "Move the pallet by the truck onto it": (
        "EVENT(r = Move, l = OBJ(f = OBJ(f = the pallet), r = by, l = OBJ(f = the truck)), "
        "l2 = PATH(r = onto, l = OBJ(f = it)))",
        [("it", "same", ["the truck"])],
    ),
    "Lift the pallet that sits by itself": (
        "EVENT(r = Lift, l = OBJ(f = OBJ(f = the pallet), r = that sits by, l = OBJ(f = itself)))",
        [("itself", "same", ["the pallet that sits by itself"])],
    ),
    "Go to the truck that has tires on it": (
        "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = OBJ(f = the truck), l = EVENT(r = that has, "
        "l = OBJ(f = tires), l2 = PLACE(r = on, l = OBJ(f = it))))))",
        [("it", "same", ["the truck that has tires on it"])],
    ),
    "Load the tires, then move them to the trailer": (
        "EVENT(r = Load, l = OBJ(f = the tires))\n"
        "EVENT(r = move, l = OBJ(f = them), l2 = PATH(r = to, l = OBJ(f = the trailer)))",
        [("them", "same", ["the tires"])],
    ),
    "Move it from one trailer to the other trailer": (
        "EVENT(r = Move, l = OBJ(f = it), l2 = [PATH(r = from, l = OBJ(f = one trailer)), "
        "PATH(r = to, l = OBJ(f = the other trailer))])",
        [("it", "same", []), ("the other trailer", "other", ["one trailer"])],
    ),
    "Go past the loaded truck to the empty one": (
        "EVENT(r = Go, l = [PATH(r = past, l = OBJ(f = the loaded truck)), "
        "PATH(r = to, l = OBJ(f = the empty one))])",
        [("the empty one", "one", ["the loaded truck"])],
    ),
    "Lift the pallet off the trailer and put it on that trailer": (
        "EVENT(r = Lift, l = OBJ(f = the pallet), l2 = PATH(r = off, l = OBJ(f = the trailer)))\n"
        "EVENT(r = put, l = OBJ(f = it), l2 = PLACE(r = on, l = OBJ(f = that trailer)))",
        [("it", "same", ["the pallet", "the trailer"]), ("that trailer", "same", ["the trailer"])],
    ),
    "Drive past the man by the crate and do not hit him": (
        "EVENT(r = Drive, l = PATH(r = past, l = OBJ(f = OBJ(f = the man), r = by, "
        "l = OBJ(f = the crate))))\nEVENT(r = do not hit, l = OBJ(f = him))",
        [("him", "same", ["the man by the crate", "the crate"])],
    ),
    "Don't take the crate, take the box and raise it": (
        "EVENT(r = Don't take, l = OBJ(f = the crate))\nEVENT(r = take, l = OBJ(f = the box))\n"
        "EVENT(r = raise, l = OBJ(f = it))",
        [("it", "same", ["the box", "the crate"])],
    ),
    "Lift one of the pallets": (
        "EVENT(r = Lift, l = OBJ(f = OBJ(f = one), r = of, l = OBJ(f = the pallets)))",
        [],
    ),
}


def words_of(sdc):
    return " ".join(word.text for word in all_words(sdc))


@pytest.mark.parametrize("text", GOLDEN)
def test_golden(text):
    notation, expected = GOLDEN[text]
    sdcs = parse_brackets(notation, command=text)
    nodes = list(breadth_first(sdcs))
    found = [
        (
            words_of(nodes[anaphor.index]),
            anaphor.kind,
            [words_of(nodes[a.index]) for a in anaphor.antecedents],
        )
        for anaphor in anaphors(sdcs)
    ]
    assert found == expected


def test_features_of_an_antecedent():
    text = "Pick up the tire pallet off the truck and set it down"
    (anaphor,) = anaphors(parse_brackets(LIFT_AND_SET, command=text))
    pallet, truck = (antecedent.features for antecedent in anaphor.antecedents)
    assert (pallet.clauses, pallet.first, pallet.direct_object, pallet.same_role) == (1, 1, 1, 1)
    assert (truck.clauses, truck.first, truck.direct_object, truck.same_role) == (1, 0, 0, 0)
    assert pallet.agrees
    assert not pallet.in_negated
    # All but these three features are equal: the odds are exp(0.7 + 0.7 + 1.5) to 1.
    assert anaphor.antecedents[0].probability == pytest.approx(1 / (1 + math.exp(-2.9)))


@pytest.mark.parametrize(("verb", "likely"), [("lift", "the boxes"), ("put down", "the tires")])
def test_what_is_gone_to_is_taken(verb, likely):
    text = f"Move the tires, go to the boxes and {verb} them"
    move, go = "EVENT(r = Move, l = OBJ(f = the tires))", "PATH(r = to, l = OBJ(f = the boxes))"
    sdcs = parse_brackets(
        f"{move}; EVENT(r = go, l = {go}); EVENT(r = {verb}, l = OBJ(f = them))", command=text
    )
    (anaphor,) = anaphors(sdcs)
    best = anaphor.antecedents[0]
    assert words_of(list(breadth_first(sdcs))[best.index]) == likely
    assert best.features.reached == (verb == "lift")


LIKELY = "lift the pallet it them and , . on of with truck one other that itself not to rest you"


@given(st.lists(st.sampled_from(LIKELY.split()), max_size=30).map(" ".join))
def test_antecedents_stand_before_and_share_the_probability(text):
    sdcs = parse(text).sdcs
    nodes = list(breadth_first(sdcs))
    for anaphor in anaphors(sdcs):
        start = all_words(nodes[anaphor.index])[0]
        chances = [antecedent.probability for antecedent in anaphor.antecedents]
        assert chances == sorted(chances, reverse=True)
        assert not chances or math.fsum(chances) == pytest.approx(1)
        for antecedent in anaphor.antecedents:
            assert antecedent.index != anaphor.index
            assert nodes[antecedent.index].type == "OBJECT"
            assert all_words(nodes[antecedent.index])[0] <= start
