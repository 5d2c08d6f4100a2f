"""The automatic judge, on plans of which it is plain whether they are right."""

import numpy as np
import pytest

from corpus_tools.importers.authored.bundled import open_corpus
from eval.judging.judge import judge
from eval.table_3.outcomes import Outcome, reliability, risk_coverage
from g3.actions.action_kinds import Action, move, result
from g3.actions.forklift_actions import CARRY, DRIVE_TO, PICK_UP
from g3.actions.grounding_candidates import spots_about
from g3.actions.logged_actions import recorded
from g3.actions.robot_state import start_state


@pytest.fixture(scope="module")
def contexts():
    return {a.command.scenario: a.context for a in open_corpus("warehouse").annotations}


def after(context, *actions):
    state = start_state(context)
    for action in actions:
        state = result(state, action, move(state, [action]), 0)
    return state


def on(context, carrier):
    state = start_state(context)
    return spots_about((state.thing(carrier),), state)[0]


def test_the_right_load_on_the_forks_is_right(contexts):
    context = contexts["dock_pick_up_tires"]
    assert judge(context, after(context, Action(PICK_UP, "tires-2"))).correct


def test_another_load_is_wrong_and_the_verdict_says_why(contexts):
    context = contexts["dock_pick_up_tires"]
    verdict = judge(context, after(context, Action(PICK_UP, "tires-1")))
    assert not verdict.correct
    assert "tires-2" not in verdict.reason


def test_doing_nothing_is_wrong(contexts):
    for context in contexts.values():
        assert not judge(context, start_state(context)).correct


@pytest.mark.parametrize(("carrier", "right"), [("trailer-1", True), ("truck-1", False)])
def test_a_load_belongs_on_what_the_log_puts_it_on(carrier, right, contexts):
    context = contexts["court_put_crate_on_trailer"]
    action = Action(CARRY, "crate-1", place=on(context, carrier))
    assert judge(context, after(context, action)).correct is right


def test_where_the_log_drives_is_right(contexts):
    context = contexts["depot_go_to_storage"]
    track = recorded(context).agent.trajectory
    state = start_state(context)
    goal = next(
        p
        for p in context.places
        if np.linalg.norm(p.prism.xy.mean(axis=0) - track.xyz[-1, :2]) < 2.0
    )
    drive = Action(DRIVE_TO, target=(goal,))
    assert judge(context, after(context, drive)).correct
    assert not judge(context, state).correct


def outcome(probability, correct):
    return Outcome("c", "s", "text", probability, correct, "")


def test_perfectly_stated_probabilities_have_no_calibration_error():
    outcomes = [outcome(0.75, i < 3) for i in range(4)] + [outcome(0.25, i < 1) for i in range(4)]
    error, diagram = reliability(outcomes)
    assert error.value == pytest.approx(0.0)
    assert [row["n"] for row in diagram] == [4, 4]


def test_certain_and_wrong_has_the_largest_error():
    assert reliability([outcome(1.0, False)] * 3)[0].value == pytest.approx(1.0)


def test_risk_is_that_of_the_most_probable():
    # Of the one most probable none is wrong, of two a half, of three a third.
    given = [outcome(0.1, True), outcome(0.9, True), outcome(0.5, False)]
    assert risk_coverage(given).value == pytest.approx((0 + 1 / 2 + 1 / 3) / 3)
