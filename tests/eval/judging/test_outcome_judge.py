"""Plans against outcomes, in a yard where it is plain whether they are right."""

import pytest

from eval.judging.judge import expected, judge_outcome, picked_in_log, picked_up
from g3.actions.action_kinds import Action, move, result
from g3.actions.forklift_actions import CARRY, GO_STRAIGHT, PICK_UP, TURN
from g3.actions.grounding_candidates import spots_about, spots_of_robot
from g3.actions.robot_state import loads_of_context, start_state
from g3.annotation import TaskOutcome
from tests.eval.yard import yard


@pytest.fixture(scope="module")
def corpus(tmp_path_factory):
    return yard(tmp_path_factory.mktemp("yard"), two_trailers=True)


@pytest.fixture(scope="module")
def start(corpus):
    (context,) = corpus.contexts.values()
    return start_state(context)


def on(state, carrier):
    return spots_about((state.thing(carrier),), state)[0]


def verdict(start, outcomes, *actions):
    state = start
    for action in actions:
        state = result(state, action, move(state, [action]), 0)
    want, picked = expected(outcomes), picked_up(start, actions, state)
    return judge_outcome(want, picked, start, state), picked == want.picked


def done(**about):
    return TaskOutcome("o", "s", "c", **about)


def test_what_is_on_the_forks_belongs_there(start):
    held = [done(picked=("11",), put="held")]
    assert verdict(start, held, Action(PICK_UP, "11"))[0].correct
    other = verdict(start, held, Action(PICK_UP, "12"))
    assert (other[0].correct, other[1]) == (False, False)
    put = Action(CARRY, "11", place=on(start, "13"))
    wrong, same_load = verdict(start, held, put)
    # The right load, but not the whole outcome.
    assert (wrong.correct, same_load) == (False, True)
    assert "forks" in wrong.reason


def test_any_of_the_things_that_it_may_have_been_put_on_will_do(start):
    either = [done(picked=("11",), put="on", on=("13", "15"), unknown=("on",))]
    first = [done(picked=("11",), put="on", on=("13",))]
    for trailer, right in (("13", True), ("15", False)):
        action = Action(CARRY, "11", place=on(start, trailer))
        assert verdict(start, either, action)[0].correct
        assert verdict(start, first, action)[0].correct is right
    ground = Action(CARRY, "11", place=spots_of_robot(start)[0])
    assert not verdict(start, either, ground)[0].correct
    nobody_knows = [done(picked=("11",), put="on", unknown=("on",))]
    assert verdict(start, nobody_knows, action)[0].correct
    assert not verdict(start, nobody_knows, ground)[0].correct


def test_anywhere_on_the_ground_is_right_where_the_place_is_unknown(start):
    ground = [done(picked=("11",), put="ground", unknown=("place",))]
    for place, right in ((spots_of_robot(start)[1], True), (on(start, "13"), False)):
        assert verdict(start, ground, Action(CARRY, "11", place=place))[0].correct is right
    assert not verdict(start, ground, Action(PICK_UP, "11"))[0].correct


def test_who_only_drives_picks_up_nothing(start):
    drove = [done(unknown=("place",)), done(unknown=("place",))]
    assert verdict(start, drove, Action(GO_STRAIGHT, amount=4.0)) == (
        verdict(start, drove, Action(TURN, amount=1.0))
    )
    assert verdict(start, drove, Action(GO_STRAIGHT, amount=4.0))[0].correct
    wrong, same_load = verdict(start, drove, Action(PICK_UP, "12"))
    assert (wrong.correct, same_load) == (False, False)
    assert "12" in wrong.reason


def test_the_last_outcome_of_a_thing_counts_and_others_must_be_left_alone(start):
    task = [
        done(picked=("11",), put="held"),
        done(picked=("11",), put="on", on=("13",)),
        done(picked=("12",), put="held"),
    ]
    carry, lift = Action(CARRY, "11", place=on(start, "13")), Action(PICK_UP, "12")
    assert verdict(start, task, carry, lift)[0].correct
    assert not verdict(start, task, carry)[0].correct
    # If more may have been done, what else is picked up isn't wrong.
    alone = [done(picked=("12",), put="held")]
    more = [done(picked=("12",), put="held", unknown=("rest",))]
    assert not verdict(start, alone, carry, lift)[0].correct
    assert verdict(start, more, carry, lift)[0].correct


@pytest.mark.parametrize(
    ("unknown", "picked", "whole", "determined", "tells"),
    [
        ((), ("11",), True, True, True),
        (("on",), ("11",), True, True, True),
        (("place",), (), True, False, True),
        (("rest",), ("11",), False, False, True),
        (("picked", "put"), (), False, False, False),
    ],
)
def test_what_outcomes_tell(unknown, picked, whole, determined, tells):
    found = expected([done(picked=picked, unknown=unknown)])
    assert (found.is_whole, found.is_determined, found.tells) == (whole, determined, tells)
    assert expected([]).tells is False


def test_loads_are_pallets_and_no_people(corpus):
    (context,) = corpus.contexts.values()
    assert [o.id for o in loads_of_context(context)] == ["11", "12"]
    assert picked_in_log(context) == frozenset()
