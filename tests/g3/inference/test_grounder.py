"""Commands in a world that the model hasn't seen."""

import numpy as np
import pytest

from g3.actions.forklift_actions import WAIT
from g3.actions.robot_state import is_load, moved_to, start_state, with_moved
from g3.geometry.plane import rotate
from g3.groundings import object_ids
from g3.inference.clarification import told_apart
from g3.inference.grounder import Grounder
from g3.language.parsing.parser import parse_unsure
from g3.language.parsing.trees import Parse, Tree
from g3.sdc.sdc_notation import parse_brackets
from tests.g3.inference.following_commands import did, under


def test_a_load_is_picked_up_and_put_down(grounder, dock):
    sdcs = parse_brackets(
        "EVENT(r = Pick up, l = OBJ(f = the crate));"
        "EVENT(r = put, l = OBJ(f = it), l2 = PLACE(r = on, l = OBJ(f = the trailer)))"
    )
    found = grounder.follow(sdcs, dock)
    assert [kind for kind, _ in did(found)] == ["pick up", "put down"]
    (load,) = {i for _, i in did(found)}
    assert under(found, load) == "trailer-1"
    trailer, carried = (found.plan.state.thing(i).prism for i in ("trailer-1", load))
    assert carried.z_min == pytest.approx(trailer.z_max, abs=1e-6)


def test_the_same_command_gives_the_same_plans(model, dock):
    sdcs = parse_brackets("EVENT(r = Lift, l = OBJ(f = the boxes))")
    first, second = (Grounder.load(model).follow(sdcs, dock, top=3) for _ in range(2))
    assert [(p.score, did(first)) for p in first.plans] == [
        (p.score, did(second)) for p in second.plans
    ]


def test_every_clause_that_is_grounded_has_a_probability(grounder, dock):
    sdcs = parse_brackets("EVENT(r = Pick up, l = OBJ(f = the boxes))")
    plan = grounder.follow(sdcs, dock, explain=True).plan
    by_text = {g.text: g for g in plan.groundings}
    boxes = by_text["the boxes"]
    assert object_ids(boxes.group)[0].startswith("boxes")
    assert 0 < boxes.probability <= 1
    assert boxes.reasons
    event = by_text["Pick up the boxes"]
    assert event.rival not in (None, plan.actions[0])
    assert event.reasons


def test_an_answer_settles_which_thing_is_meant(grounder, dock):
    sdcs = parse_brackets("EVENT(r = Pick up, l = OBJ(f = the boxes))")
    node = 2  # the EVENT, the implicit robot, the boxes
    for wanted in ("boxes-1", "boxes-2"):
        plan = grounder.follow(sdcs, dock, answers={node: wanted}).plan
        assert did_objects(plan) == [wanted]


def did_objects(plan):
    return [a.object_id for a in plan.actions]


def test_a_negated_clause_does_nothing(grounder, dock):
    text = "Don't pick up the crate"
    sdcs = parse_brackets("EVENT(r = Don't pick up, l = OBJ(f = the crate))", command=text)
    found = grounder.follow(sdcs, dock)
    assert [action.kind for action in found.plan.actions] == [WAIT]
    assert found.question is None


@pytest.mark.parametrize("notation", ["EVENT(r = fly)", "EVENT(r = please yodel)"])
def test_unknown_verbs_without_arguments_are_refused(notation, grounder, dock):
    found = grounder.follow(parse_brackets(notation), dock)
    assert found.plan is None
    assert "means" in found.note


def test_plans_for_unknown_verbs_are_told_to_be_guesses(grounder, dock):
    known, unknown = (
        grounder.follow(parse_brackets(f"EVENT(r = {verb}, l = OBJ(f = the boxes))"), dock, least=0)
        for verb in ("Lift", "Blick")
    )
    assert did_objects(known.plan) == did_objects(unknown.plan)
    assert known.plan.probability > unknown.plan.probability
    assert not known.note
    assert "'blick'" in unknown.note


def test_no_clause_is_no_plan(grounder, dock):
    assert grounder.follow((), dock).plan is None


def test_things_are_told_apart_as_they_stand_before_anything_is_done(dock):
    state = start_state(dock)
    ahead = state.pose[:2] + 5 * np.array([np.cos(state.pose[2]), np.sin(state.pose[2])])
    thing = state.thing("boxes-1")
    yaw = float(thing.trajectory.yaw[0])
    moved = with_moved(state, {thing.id: moved_to(thing, np.array([*ahead, yaw]), 0.0)}, None)
    assert told_apart(moved, ["boxes-1"]) == ["the one ahead of you"]


def test_one_verb_that_nobody_taught_does_not_spoil_the_others(grounder, dock):
    lift = "EVENT(r = Pick up, l = OBJ(f = the boxes))"
    found = grounder.follow(parse_brackets(f"EVENT(r = yodel);{lift}"), dock)
    assert found.plan is not None, found.note
    assert did(found)[-1] in [("pick up", "boxes-1"), ("pick up", "boxes-2")]


def lift(thing, verb="Lift"):
    return parse_brackets(f"EVENT(r = {verb}, l = OBJ(f = the {thing}))")


def several(*trees):
    return Parse("", tuple(Tree(sdcs, chance) for chance, sdcs in trees))


def test_one_tree_is_followed_as_its_clauses_are(grounder, dock):
    alone = grounder.follow(lift("boxes"), dock, least=0.0)
    for trees in ([(0.3, lift("boxes"))], [(0.2, lift("boxes")), (0.3, lift("boxes"))]):
        found = grounder.follow(several(*trees), dock, least=0.0)
        assert (found.sdcs, did(found)) == (alone.sdcs, did(alone))
        assert found.plan.probability == pytest.approx(alone.plan.probability)


def test_trees_that_lead_to_the_same_count_together(grounder, dock):
    tires, boxes, again = lift("tires"), lift("boxes"), lift("boxes", "Lift up")
    together = several((0.3, tires), (0.25, boxes), (0.25, again))
    assert "boxes" in did(grounder.follow(together, dock, least=0.0))[0][1]
    alone = grounder.follow(tires, dock, least=0.0)
    found = grounder.follow(several((0.5, tires), (0.05, boxes)), dock, least=0.0)
    assert did(found) == did(alone)
    assert found.plan.probability < alone.plan.probability


def test_a_tree_that_nothing_comes_of_takes_its_part(grounder, dock):
    nothing = parse_brackets("EVENT(r = yodel)")
    found = grounder.follow(several((0.5, nothing), (0.4, lift("boxes"))), dock, least=0.0)
    alone = grounder.follow(lift("boxes"), dock, least=0.0)
    assert did(found) == did(alone)
    assert 0 < found.plan.probability < alone.plan.probability
    refused = grounder.follow(several((0.5, nothing), (0.4, nothing)), dock)
    assert "'yodel'" in refused.note


def test_a_text_is_followed_as_its_trees_are(grounder, dock):
    text = "Put the boxes on the trailer next to the crate"
    trees = parse_unsure(text, n_best=3)
    found = grounder.follow(text, dock, parses=3, least=0.0)
    assert found.plan.probability == grounder.follow(trees, dock, least=0.0).plan.probability
    assert found.sdcs in {tree.sdcs for tree in trees.trees}


def test_a_pronoun_means_what_its_words_say_rather_than_what_came_last(grounder, dock):
    sdcs = parse_brackets(
        "EVENT(r = Pick up, l = OBJ(f = the boxes));"
        "EVENT(r = go, l = PATH(r = to, l = OBJ(f = the trailer)));"
        "EVENT(r = put, l = OBJ(f = it), l2 = PLACE(r = on, l = OBJ(f = the trailer)))"
    )
    plan = grounder.follow(sdcs, dock).plan
    by_text = {g.text: object_ids(g.group) for g in plan.groundings}
    assert by_text["it"] == by_text["the boxes"]


@pytest.mark.parametrize(
    ("spots", "texts"),
    [
        # Ahead side by side, one behind the other, and on two sides of the robot.
        ([(5, 0.5), (5, -1)], ["the left one ahead of you", "the right one ahead of you"]),
        ([(9, 0), (5, 0.5)], ["the far one ahead of you", "the near one ahead of you"]),
        ([(-5, 1), (5, 0)], ["the one behind you", "the one ahead of you"]),
        # Left is the left of who turns to them.
        ([(-5, 2), (-5, -2)], ["the right one behind you", "the left one behind you"]),
    ],
)
def test_things_are_told_apart_by_what_differs_most(spots, texts, dock):
    state = start_state(dock)
    moved = {}
    for object_id, spot in zip(("boxes-1", "tires-2"), spots, strict=True):
        there = state.pose[:2] + rotate(np.array(spot, dtype=float), state.pose[2])
        thing = state.thing(object_id)
        moved[object_id] = moved_to(thing, np.array([*there, thing.trajectory.yaw[0]]), 0.0)
    assert told_apart(with_moved(state, moved, None), ["boxes-1", "tires-2"]) == texts


@pytest.mark.parametrize("name", ["receiving", "issue area"])
def test_a_place_with_a_name_is_gone_to(name, grounder, dock):
    sdcs = parse_brackets(f"EVENT(r = drive, l = PATH(r = to, l = OBJ(f = {name})))")
    found = grounder.follow(sdcs, dock, least=0.0)
    place = next(p for p in dock.places if p.name == name)
    away = found.plan.state.pose[:2] - place.prism.xy.mean(axis=0)
    assert np.linalg.norm(away) < 3


def test_what_was_picked_up_is_put_down_where_it_is_taken(grounder, dock):
    sdcs = parse_brackets(
        "EVENT(r = Lift, l = OBJ(f = the crate));"
        "EVENT(r = take, l = OBJ(f = it), l2 = PATH(r = to, l = OBJ(f = the trailer)))"
    )
    found = grounder.follow(sdcs, dock)
    assert [kind for kind, _ in did(found)] == ["pick up", "put down"]


def test_nobody_is_picked_up(dock):
    person = next(o for o in dock.objects if "person" in o.labels)
    assert not is_load(start_state(dock), person.id)
