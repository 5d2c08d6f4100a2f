"""Reasons in plain words."""

from g3.features.feature_registry import select
from g3.groundings import object_ids
from g3.inference.problem.scoring import Reason
from g3.inference.reasons.aspects import ASPECTS, aspects
from g3.sdc.sdc_notation import parse_brackets


def test_reasons_of_a_sort_are_told_together():
    (clause,) = parse_brackets("OBJ(f = the tyres)")
    reasons = [
        Reason("word-form/spelling.own", "figure:tire", 1.0),
        Reason("labels/tire", "figure:tire", 0.5),
        Reason("labels/pallet", "figure:the", 0.7),
        Reason("ranks/ahead.first", "", -0.7),
        Reason("bearing/ahead", "", 0.01),
        Reason("scene/occupied", "", 0.05),
    ]
    # e^2.2 is 9.0 and e^0.69 is 2.0; what tells next to nothing isn't told.
    assert [aspect.text for aspect in aspects(reasons, clause)] == [
        '9.0 times likelier for what it is called ("tyres")',
        "2.0 times less likely for where it stands, seen from the robot and among things alike",
    ]


def test_what_is_certain_is_told_without_a_large_number():
    (clause,) = parse_brackets("OBJ(f = it)")
    (aspect,) = aspects([Reason("besides/way", "", 12.0)], clause)
    assert aspect.text == (
        "over 100 times likelier for the rule way: an action without a goal goes the way that "
        'words name: "back up"'
    )


def test_a_feature_set_of_somebody_else_describes_itself():
    (clause,) = parse_brackets("OBJ(f = it)")
    (aspect,) = aspects([Reason("colours/red", "figure:it", 1.0)], clause)
    assert aspect.about == "colours"


def test_every_feature_set_is_told_in_plain_words():
    assert {s.name for s in select()} <= ASPECTS.keys()


def test_a_thing_is_explained_against_the_best_other_one(grounder, dock):
    text = "EVENT(r = Pick up, l = OBJ(f = OBJ(f = the tires), r = on the left))"
    plan = grounder.follow(parse_brackets(text), dock, explain=True).plan
    by_text = {g.text: g for g in plan.groundings}
    chosen = by_text["the tires on the left"]
    # The outermost clause has the reasons of all that name the thing.
    assert by_text["the tires"].reasons == ()
    assert object_ids(chosen.rival)
    assert not set(object_ids(chosen.rival)) & set(object_ids(chosen.group))
    assert {"ranks", "labels"} & {r.feature.split("/")[0] for r in chosen.reasons}
    weights = [abs(reason.weight) for reason in chosen.reasons]
    assert weights == sorted(weights, reverse=True)
