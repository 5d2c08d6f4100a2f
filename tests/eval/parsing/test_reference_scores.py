"""Antecedents and numbers against groundings, worked by hand."""

from __future__ import annotations

from eval.parsing.sdc_scores import ReferenceScores, reference_scores
from g3.annotation import Annotation, Command
from g3.groundings import Context
from g3.sdc.clauses import breadth_first
from g3.sdc.sdc_notation import parse_brackets
from tests.worlds import thing

TEXT = "Lift the pallet off the truck and put it down"
NOTATION = (
    "EVENT(r = Lift, l = OBJ(f = the pallet), l2 = PATH(r = off, l = OBJ(f = the truck)))\n"
    "EVENT(r = put down, l = OBJ(f = it))"
)


PALLET, TRUCK, ROBOT = (
    thing(name, name, 3.0 * i, 0.0, (1, 1)) for i, name in enumerate(("pallet", "truck", "robot"))
)
CONTEXT = Context("yard", (PALLET, TRUCK, ROBOT), (), "robot")


def annotation(number, text, notation, meant, source="positive"):
    sdcs = parse_brackets(notation, command=text)
    nodes = list(breadth_first(sdcs))
    words = [" ".join(span.text for span in node.words) for node in nodes]
    groundings = tuple(meant.get(word, ()) for word in words)
    command = Command(f"c{number}", text, "yard")
    correct = (None,) * len(nodes)
    return Annotation(f"a{number}", command, CONTEXT, sdcs, groundings, correct, source)


def test_a_right_and_a_wrong_antecedent():
    meant = {"the pallet": (PALLET,), "the truck": (TRUCK,)}
    right = annotation(1, TEXT, NOTATION, {**meant, "it": (PALLET,)})
    wrong = annotation(2, TEXT, NOTATION, {**meant, "it": (TRUCK,)})
    nowhere = annotation(3, TEXT, NOTATION, {**meant, "it": (ROBOT,)})
    ungrounded = annotation(4, TEXT, NOTATION, meant)
    scores = reference_scores([right, wrong, nowhere, ungrounded])
    assert (scores.pronouns, scores.any_antecedent, scores.first_antecedent) == (3, 2, 1)
    assert (scores.singular, scores.singular_of_one) == (11, 11)


def test_numbers():
    text = "Lift tires and the pallet on the truck"
    notation = (
        "EVENT(r = Lift, l = [OBJ(f = tires), OBJ(f = OBJ(f = the pallet), r = on, "
        "l = OBJ(f = the truck))])"
    )
    meant = {"tires": (PALLET, TRUCK), "the pallet": (PALLET,), "the truck": (PALLET, TRUCK)}
    scores = reference_scores([annotation(1, text, notation, meant)])
    # The figure of an OBJECT with modifiers is not counted beside it.
    assert (scores.singular, scores.singular_of_one) == (1, 0)
    assert (scores.plural, scores.plural_of_one) == (1, 0)


def test_only_the_first_positive_annotation_of_a_command_counts():
    meant = {"the pallet": (PALLET,), "it": (PALLET,)}
    once = annotation(1, TEXT, NOTATION, meant)
    random = annotation(2, TEXT, NOTATION, meant, source="random")
    assert reference_scores([random]) == ReferenceScores()
    assert reference_scores([once, once, random]) == reference_scores([once])
