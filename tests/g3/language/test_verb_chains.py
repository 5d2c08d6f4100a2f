"""Which verb of a clause says what to do."""

import pytest

from g3.language.lexicon.verb_chains import verb_of


@pytest.mark.parametrize(
    ("words", "verb", "classes"),
    [
        ("fetch", "fetch", "taking"),
        ("go fetch", "fetch", "taking"),
        ("get ready to deposit", "deposit", "placing"),
        ("please now carefully lower", "lower", "placing"),
        ("begin by hoisting", "hoisting", "taking"),
        ("should try to haul", "haul", "carrying"),
        ("would like to start driving", "driving", "going"),
        ("do n't grab", "grab", "taking"),
        ("come to a halt", "halt", "staying"),
        # A way behind a verb is no verb.
        ("go back", "go back", "going"),
        ("continue straight on", "continue straight on", "going"),
        # Who stops lifting doesn't lift.
        ("stop lifting", "stop lifting", "staying"),
        ("lift and deliver", "lift and deliver", "carrying+taking"),
        # Particles.
        ("let down", "let down", "placing"),
        ("set down", "set down", "placing"),
        ("drop off", "drop off", "placing"),
        ("back up", "back up", "going"),
        ("line up", "line up", "going+placing"),
    ],
)
def test_the_content_verb_decides(words, verb, classes):
    found = verb_of(tuple(words.split()))
    assert " ".join(words.split()[found.start :]) == verb
    assert "+".join(sorted(found.classes)) == classes
    assert not found.is_open


@pytest.mark.parametrize("words", ["blick", "proceed to blick", "please blick", "go and blick"])
def test_an_unknown_verb_is_open(words):
    found = verb_of(tuple(words.split()))
    assert found.is_open
    assert words.split()[found.start] == "blick"


@pytest.mark.parametrize("words", ["", "is", "there are", "until", "see", "use", "3", "left"])
def test_what_is_no_verb_of_doing_is_not_open(words):
    found = verb_of(tuple(words.split()))
    assert not found.is_open
    assert not found.classes
