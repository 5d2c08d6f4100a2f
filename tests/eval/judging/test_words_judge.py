"""The second verdict, on plans and logs of which it is plain whether they do what words say."""

import json
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest

from corpus_tools.importers.authored.bundled import open_corpus
from eval.judging.execution import logged, planned
from eval.judging.grounded_command import grounded_command, meanings
from eval.judging.words_judge import allowed, judge_by_words, judge_clauses
from g3.actions.action_kinds import Action
from g3.actions.forklift_actions import CARRY, DRIVE_TO, PICK_UP
from g3.actions.grounding_candidates import spots_about
from g3.actions.robot_state import start_state
from g3.geometry.relations import in_frame, is_between, looking_at
from g3.groundings import Prism
from g3.sdc.clauses import Span
from g3.sdc.sdc_notation import parse_brackets


@pytest.fixture(scope="module")
def commands():
    """The annotations of the bundled commands by their ids."""
    return {a.command.id: a for a in open_corpus("warehouse").annotations if a.source == "positive"}


def on(annotation, carrier, which=0):
    state = start_state(annotation.context)
    return spots_about((state.thing(carrier),), state)[which]


def beside(annotation, thing):
    """A spot on the ground next to a thing that can't be stood upon."""
    return on(annotation, thing)


def verdict(annotation, *actions):
    return judge_by_words(annotation, planned(annotation.context, actions))


def pick_up(load):
    return Action(PICK_UP, load)


@pytest.mark.parametrize(
    ("command", "load", "right"),
    [
        # "Get crate onto trailor" and "transfer the crate" fit each of two crates,
        ("court_put_crate_on_trailer-04", "crate-1", True),
        ("court_put_crate_on_trailer-04", "crate-2", True),
        # "the left crate" one of them.
        ("court_put_crate_on_trailer-01", "crate-1", True),
        ("court_put_crate_on_trailer-01", "crate-2", False),
        ("court_put_crate_on_trailer-01", "boxes-1", False),
    ],
)
def test_any_thing_that_the_words_allow_is_right(command, load, right, commands):
    own = commands[command]
    assert verdict(own, Action(CARRY, load, place=on(own, "trailer-1"))).correct is right


@pytest.mark.parametrize("which", [0, 1, 2])
def test_any_spot_on_what_is_named_is_right_and_another_carrier_is_wrong(which, commands):
    own = commands["court_put_crate_on_trailer-01"]
    assert verdict(own, Action(CARRY, "crate-1", place=on(own, "trailer-1", which))).correct
    wrong = verdict(own, Action(CARRY, "crate-1", place=on(own, "truck-1", which)))
    assert wrong.reason == "the load doesn't end where the words say"


def test_what_the_words_do_not_speak_of_stays_where_it_is(commands):
    own = commands["court_put_crate_on_trailer-01"]
    put = Action(CARRY, "crate-1", place=on(own, "trailer-1"))
    more = Action(CARRY, "boxes-1", place=beside(own, "barrel-1"))
    wrong = verdict(own, put, more)
    assert wrong.reason == "it moves boxes-1, which the words don't speak of"


def test_a_singular_speaks_of_one_thing(commands):
    # "Get crate onto trailor"
    own = commands["court_put_crate_on_trailer-04"]
    both = [Action(CARRY, f"crate-{n}", place=on(own, "trailer-1", n)) for n in (1, 2)]
    assert verdict(own, *both).reason == "it moves more than the words say"


def test_what_is_asked_for_must_be_done(commands):
    begins = ("pick", "put", "move", "lift", "go", "drive to")
    asked = [a for a in commands.values() if a.command.text.lower().startswith(begins)]
    assert len(asked) > 50
    for annotation in asked:
        assert not verdict(annotation).correct, annotation.command.text


def as_a_log(annotation, *actions):
    """What a video that may stop early or go on shows."""
    return judge_by_words(annotation, replace(planned(annotation.context, actions), whole=False))


def test_a_log_may_go_on_with_its_load_and_a_plan_may_not(commands):
    own = commands["hall_pick_up_boxes-01"]
    picked = Action(CARRY, "boxes-1", place=beside(own, "barrel-1"))
    assert verdict(own, pick_up("boxes-1")).correct
    assert verdict(own, picked).reason == "it puts down what it is only to pick up"
    assert as_a_log(own, picked).correct


@pytest.mark.parametrize(("load", "right"), [("boxes-1", True), ("boxes-2", False)])
def test_things_are_told_by_what_is_around_them(load, right, commands):
    # "Pick up the boxes between the tire pallets."
    assert verdict(commands["hall_pick_up_boxes-01"], pick_up(load)).correct is right


def test_a_log_may_stop_before_the_load_is_put_down_and_a_plan_may_not(commands):
    own = commands["yard_put_boxes_down_on_trailer-05"]
    trailer = (start_state(own.context).thing("trailer-1"),)
    near = Action(DRIVE_TO, target=trailer)
    assert as_a_log(own, near).correct
    assert not verdict(own, near).correct
    # "Put down the boxes" names no place that it could have come near to.
    nowhere = commands["yard_put_boxes_down_on_trailer-10"]
    assert as_a_log(nowhere, near).reason == "the load isn't put down"


@pytest.mark.parametrize(
    ("name", "right"), [("storage D", True), ("storage E", False), ("truck-1", False)]
)
def test_the_robot_ends_where_it_is_sent(name, right, commands):
    own = commands["depot_go_to_storage-01"]
    things = {p.name: p for p in own.context.places} | {o.id: o for o in own.context.objects}
    assert verdict(own, Action(DRIVE_TO, target=(things[name],))).correct is right


def test_a_driving_command_moves_no_load(commands):
    own = commands["depot_go_to_storage-01"]
    place = next(p for p in own.context.places if p.name == "storage D")
    wrong = verdict(own, pick_up("tires-1"), Action(DRIVE_TO, target=(place,)))
    assert wrong.reason == "it moves a load, of which the words don't speak"


def test_own_logs_do_what_was_said_of_them(commands):
    # People have typed and annotated these for the logs; not all that they say can be measured.
    some = [a for i, a in sorted(commands.items()) if i.endswith(("-01", "-05", "-08"))]
    deeds = {a.context.id: logged(a.context) for a in some}
    verdicts = [judge_by_words(a, deeds[a.context.id]) for a in some]
    assert np.mean([bool(v and v.correct) for v in verdicts]) >= 0.95


def test_a_log_of_another_world_is_judged_by_what_stands_there(commands):
    # Both in the court: the one picks tires up from a truck, the other boxes from the trailer.
    tires = commands["court_pick_up_tires_off_truck-01"]
    boxes = commands["court_pick_up_boxes_from_trailer-01"]
    for own, other in ((tires, boxes), (boxes, tires)):
        assert judge_by_words(own, logged(own.context)).correct
        assert not judge_by_words(own, logged(other.context)).correct


def test_plans_and_logs_tell_of_the_same_deeds(commands):
    own = commands["court_put_crate_on_trailer-01"]
    planned_deeds = planned(own.context, [Action(CARRY, "crate-1", place=on(own, "trailer-1"))])
    for deeds in (planned_deeds, logged(own.context)):
        [load] = deeds.carried
        assert load.id == "crate-1"
        assert 0 < load.lifted < load.lowered < len(deeds.way)
        assert deeds.start.held is deeds.end.held is None
    assert not planned(own.context, [pick_up("crate-1")]).carried[0].lowered


def test_the_annotated_thing_is_always_allowed_in_its_own_world(commands):
    for annotation in list(commands.values())[::7]:
        words = grounded_command(annotation, start_state(annotation.context))
        for node, sdc in enumerate(words.nodes):
            if sdc.type == "OBJECT":
                assert words.things[node] <= allowed(words, node)


def box(x, y):
    corners = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    return Prism(corners + np.array([x, y]), 0.0, 1.0)


def test_between_by_hand():
    ends = [box(0, 0), box(10, 0)]
    assert is_between(box(5, 2.9), ends)
    assert not is_between(box(5, 3.1), ends)
    assert not is_between(box(-1, 0), ends)
    assert not is_between(box(5, 0), ends[:1])


def test_what_is_seen_is_ahead_and_to_the_left():
    pose = np.array([1.0, 2.0, np.pi / 2])
    assert in_frame(np.array([[1.0, 5.0], [0.0, 2.0]]), pose) == pytest.approx(
        np.array([[3.0, 0.0], [0.0, 1.0]])
    )
    assert looking_at(pose, np.array([[3.0, 2.0]]))[2] == pytest.approx(0.0)


def test_without_annotated_clauses_it_does_not_judge(commands):
    own = commands["hall_pick_up_boxes-01"]
    done = planned(own.context, [pick_up("boxes-1")])
    assert judge_by_words(None, done) is None
    nothing_asked = replace(own, sdcs=(), groundings=(), correct=())
    assert judge_by_words(nothing_asked, done) is None
    nowhere = replace(
        commands["depot_go_to_storage-01"],
        groundings=tuple(() for _ in commands["depot_go_to_storage-01"].groundings),
    )
    drive = Action(DRIVE_TO, target=(start_state(nowhere.context).thing("truck-1"),))
    assert judge_by_words(nowhere, planned(nowhere.context, [drive])) is None


CLAUSES = """
EVENT_1(r = Pick up, l = OBJ_2(f = the left crate))
EVENT_3(r = put, l = OBJ_4(f = it), l2 = PLACE_5(r = on, l = OBJ_6(f = the trailer)))
"""


@pytest.mark.parametrize(
    ("load", "carrier", "right"),
    [
        ("crate-1", "trailer-1", True),
        ("crate-1", "truck-1", False),
        ("crate-2", "trailer-1", False),
    ],
)
def test_clauses_in_brackets_are_grounded_by_labels(load, carrier, right, commands):
    own = commands["court_put_crate_on_trailer-01"]
    text = "Pick up the left crate and put it on the trailer."
    done = planned(own.context, [Action(CARRY, load, place=on(own, carrier))])
    assert judge_clauses(parse_brackets(CLAUSES, command=text), done).correct is right


def test_clauses_about_what_has_no_label_are_not_judged(commands):
    own = commands["court_put_crate_on_trailer-01"]
    done = planned(own.context, [pick_up("crate-1")])
    sdcs = parse_brackets("EVENT(r = fetch, l = OBJ(f = the gizmo))", command="fetch the gizmo")
    assert judge_clauses(sdcs, done) is None


def test_each_row_of_the_table_of_words_has_an_example_of_it():
    rows = (files("eval.judging") / "words.jsonl").read_text(encoding="utf-8").splitlines()
    assert len(rows) > 20
    for row in map(json.loads, rows):
        spans = [Span(0, word) for word in row["example"].split()]
        assert row["means"] in meanings(spans), row
