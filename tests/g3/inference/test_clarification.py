"""Questions back, and answers to them in words."""

import pytest

from g3.errors import AnswerError, ModelError
from tests.g3.inference.following_commands import did, world


@pytest.fixture(scope="module")
def grounder(widely_trained):
    return widely_trained


@pytest.fixture(scope="module")
def asked(grounder):
    """A command that leaves open which of two crates is meant: left, or right beside a barrel."""
    there = world(
        crate_1=("crate", (10, 4)),
        crate_2=("crate", (10, -4)),
        barrel_1=("barrel", (13, -6)),
        truck_1=("truck", (18, 0)),
    )
    return grounder.follow("Put the crate on the truck", there)


LEFT, RIGHT = ("carry", "crate-1"), ("carry", "crate-2")


@pytest.mark.parametrize(
    ("reply", "done"),
    [
        ("the right one", [RIGHT]),
        ("Left!", [LEFT]),
        ("the crate on the left", [LEFT]),
        ("the one by the barrel", [RIGHT]),
        ("next to the barrel, please", [RIGHT]),
        ("not the left one", [RIGHT]),
        ("both", [LEFT, RIGHT]),
        ("all of them", [LEFT, RIGHT]),
        ("the left one and the right one", [LEFT, RIGHT]),
        ("2", [RIGHT]),
        ("number two", [RIGHT]),
        ("the second one", [RIGHT]),
    ],
)
def test_a_question_is_answered_in_words(grounder, asked, reply, done):
    told = grounder.answer(asked, reply)
    assert did(told) == done
    assert told.question is None


def test_whichever_takes_the_most_probable(grounder, asked):
    assert did(grounder.answer(asked, "whichever")) == did(asked)


@pytest.mark.parametrize("reply", ["neither", "none of them"])
def test_where_neither_is_meant_nothing_is_done(grounder, asked, reply):
    told = grounder.answer(asked, reply)
    assert told.plan is None
    assert "none of these" in told.note


@pytest.mark.parametrize("reply", ["", "banana", "3", "the far one", "yes", "not both"])
def test_an_unclear_answer_names_what_is_possible(grounder, asked, reply):
    with pytest.raises(AnswerError, match=r"1\. the left one ahead of you; 2\. the right one"):
        grounder.answer(asked, reply)


def test_answers_in_words_go_with_the_command(grounder, asked):
    text, node = "Put the crate on the truck", asked.question.node
    assert did(grounder.follow(text, asked.start, answers={node: "the right one"})) == [RIGHT]
    with pytest.raises(AnswerError, match="nothing is asked about this clause"):
        grounder.follow(text, asked.start, answers={node + 1: "the right one"})


def test_no_question_has_no_answer(grounder, asked):
    with pytest.raises(ModelError, match="no question"):
        grounder.answer(grounder.answer(asked, "1"), "2")


@pytest.mark.parametrize("text", ["Put both crates on the truck", "Put the crates on the truck"])
def test_nobody_is_asked_which_of_several_that_are_all_meant(grounder, asked, text):
    assert grounder.follow(text, asked.start).question is None
