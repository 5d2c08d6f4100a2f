"""Which load a command is about, by all of its words."""

from dataclasses import replace
from math import log

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from g3.learning.load_choice import (
    CENTRE,
    PARAMETERS,
    ROLES,
    THINGS,
    Evidence,
    Load,
    LoadChoice,
    LoadChooser,
    Seen,
    evidence,
    lexicon_of,
    unknown_person,
)

TIRES, MACHINE, DRUM = ("tire", "pallet"), ("washing", "machine", "pallet"), ("drum",)
NOTHING = lexicon_of([])


def choice(text, *loads, right=(), scenario="s"):
    return LoadChoice(tuple(text.lower().split()), loads, right, "yard", scenario)


def column(name, own):
    return evidence(own, NOTHING).things[:, THINGS.index(name) - 1].tolist()


def test_the_side_that_words_name_tells_things_alike_apart():
    loads = (Load(TIRES, 4, 0.5), Load(TIRES, 8, -0.5), Load(TIRES, 6, 0.1), Load(MACHINE, 5, 1.0))
    left = choice("the tires on the left", *loads)
    assert column("side", left) == [1, -1, 0, 0]
    assert column("nearness", left) == [0, 0, 0, 0]
    assert column("side", choice("the rightmost tires", *loads)) == [-1, 1, 0, 0]
    plain = choice("the tires", *loads)
    assert column("side", plain) == [0, 0, 0, 0]
    assert column("nearness", plain) == [1, -1, 0, 0]
    assert column("distance", plain) == pytest.approx([-log(4), -log(8), -log(6), -log(5)])


def test_labels_that_most_loads_have_tell_nothing():
    loads = (Load(TIRES, 4, 0), Load(MACHINE, 5, 0), Load(DRUM, 6, 0))
    assert choice("", *loads).telling == [("tire",), ("washing", "machine"), ("drum",)]
    assert column("first label", choice("the pallet of tires", *loads)) == [1, 0, 0]
    assert column("first label", choice("the pallet", *loads)) == [0, 0, 0]


def named(text, kind, scenario):
    loads = (Load(TIRES, 5, 0.2), Load(MACHINE, 5, -0.2))
    return choice(text, *loads, right=(kind == TIRES, kind == MACHINE), scenario=scenario)


SEEN = [
    named(text, kind, f"{kind[0]}{n}")
    for text, kind in (
        ("lift the black speaker", MACHINE),
        ("take the grey speaker", MACHINE),
        ("pick up the black donuts", TIRES),
        ("take the grey donuts", TIRES),
    )
    for n in range(2)
]


def test_words_that_no_label_has_are_learned_from_what_was_done():
    learned = LoadChooser.fit(SEEN)
    unseen = named("get the speaker", MACHINE, "new")
    assert np.exp(learned.log_probability(unseen))[1] > 0.7
    assert np.exp(learned.log_probability(named("get the donuts", TIRES, "new")))[0] > 0.7
    # Not without those who said so.
    others = LoadChooser.fit([c for c in SEEN if "speaker" not in c.words])
    assert np.exp(others.log_probability(unseen))[1] < 0.6


def test_nothing_is_learned_where_there_is_no_choice():
    alone = [replace(c, loads=c.loads[:1], right=(True,)) for c in SEEN if c.right[0]]
    assert LoadChooser.fit(alone).weights.tolist() == CENTRE.tolist()
    assert LoadChooser.fit(alone).lexicon.words


def test_stronger_regularisation_moves_parameters_less():
    weak, strong = (LoadChooser.fit(SEEN, l2=l2).weights - CENTRE for l2 in (0.1, 10.0))
    assert np.linalg.norm(strong) < np.linalg.norm(weak)


def test_a_word_that_names_something_else_tells_nothing():
    # One word that makes the first load 4 times as likely and the second a quarter.
    own = Evidence(np.array([[4.0, 0.25]]), np.array([[1.0, 0.0, 0.0]]), np.zeros((2, 4)))
    parameters = np.zeros(8)
    parameters[PARAMETERS.index("words")] = 1.0
    # It names the load with probability 1/2: 1 + 1/2 * 3, and 1 - 1/2 * 3/4.
    assert own.score(parameters) == pytest.approx([log(2.5), log(0.625)])
    parameters[ROLES.index("first word")] = 30.0
    assert own.score(parameters) == pytest.approx([log(4), log(0.25)])
    parameters[ROLES.index("first word")] = -30.0
    assert own.score(parameters) == pytest.approx([0, 0])


def test_words_after_a_preposition_are_told_from_others():
    loads = (Load(TIRES, 4, 0), Load(MACHINE, 5, 0))
    own = evidence(
        choice("put the big donuts next to a red speaker over the hill", *loads), NOTHING
    )
    after = ROLES.index("word after a preposition")
    assert own.roles[:, after].tolist() == [0, 0, 1, 1, 1]  # red, speaker, hill
    assert own.roles[:, ROLES.index("each later word")].tolist() == [0, 1, 2, 3, 4]


def test_where_something_goes_does_not_name_it():
    known = LoadChooser(lexicon_of(SEEN), CENTRE)
    one = named("put the donuts next to the speaker", TIRES, "new")
    other = named("put the speaker next to the donuts", MACHINE, "new")
    assert np.exp(known.log_probability(one))[0] > 0.5
    assert np.exp(known.log_probability(other))[1] > 0.5
    # The surer it is that such words name something else, the surer the choice.
    sure = CENTRE.copy()
    sure[ROLES.index("word after a preposition")] = -5.0
    known, surer = (LoadChooser(lexicon_of(SEEN), w) for w in (CENTRE, sure))
    assert surer.log_probability(one)[0] > known.log_probability(one)[0]


def test_that_such_words_name_something_else_is_learned():
    both = [
        named(f"put the {a} next to the {b}", kind, f"{a}{n}")
        for a, b, kind in (("donuts", "speaker", TIRES), ("speaker", "donuts", MACHINE))
        for n in range(2)
    ]
    learned = LoadChooser.fit([*SEEN, *SEEN, *both])
    place = ROLES.index("word after a preposition")
    assert learned.weights[place] < CENTRE[place]


def test_a_person_whose_commands_have_nothing_to_do_with_what_was_done_teaches_less():
    careful = [
        replace(c, person="careful", scenario=f"{c.scenario}{n}") for c in SEEN for n in "ab"
    ]
    wrong = [
        replace(c, person="careless", right=c.right[::-1], scenario=f"x{c.scenario}") for c in SEEN
    ]
    speaker = named("get the speaker", MACHINE, "new")
    learned = LoadChooser.fit([*careful, *wrong])
    same = [replace(c, person="careful") for c in [*careful, *wrong]]
    assert learned.log_probability(speaker)[1] > LoadChooser.fit(same).log_probability(speaker)[1]
    # 8 careful commands had "speaker" and 4 careless ones, each of which counts less.
    (counts,) = learned.lexicon.corpora.values()
    speakers = counts.together["speaker"]
    assert speakers["tire pallet"] / 4 < speakers["washing machine pallet"] / 8 - 0.2
    assert learned.people["yard/careless"] > 1.5 * learned.people["yard/careful"]


def test_shares_of_unrelated_commands_by_hand():
    seen = Seen(["a", "b", "b"], np.array([0.9, 0.1, 0.1]), np.array([0.5, 0.5, 0.5]))
    # Of the first: 0.8 * 0.9 / (0.8 * 0.9 + 0.2 * 0.5).
    assert seen.related({})[0] == pytest.approx(0.72 / 0.82)
    assert seen.related({})[1] == pytest.approx(0.08 / 0.18)
    shares = seen.unrelated({})
    assert shares["b"] > 0.3 > shares["a"] > 0
    assert unknown_person({}) == pytest.approx(0.2)
    assert unknown_person({"a": 0.1, "b": 0.6}) == pytest.approx(0.3)


words = st.lists(
    st.sampled_from(["speaker", "donuts", "left", "the", "nearest", "zzyzx", "tires"]), max_size=6
)
load = st.builds(
    Load, st.sampled_from((TIRES, MACHINE, DRUM)), st.floats(0, 50), st.floats(-3.14, 3.14)
)


@settings(max_examples=30)
@given(words, st.lists(load, min_size=1, max_size=6))
def test_probabilities_sum_to_one_in_any_order(text, loads):
    learned = LoadChooser.fit(SEEN[:4])
    own = LoadChoice(tuple(text), tuple(loads))
    given_ = np.exp(learned.log_probability(own))
    assert given_.sum() == pytest.approx(1)
    turned = replace(own, loads=tuple(reversed(loads)))
    assert np.exp(learned.log_probability(turned))[::-1] == pytest.approx(given_)


@settings(max_examples=10)
@given(wrong=st.integers(1, 8))
def test_who_is_wrong_more_often_is_trusted_less(wrong):
    taught = [replace(c, person="p", scenario=f"{c.scenario}{n}") for c in SEEN for n in "abc"]
    others = [replace(c, person="q", scenario=f"q{c.scenario}") for c in SEEN]
    other_way = [replace(c, right=c.right[::-1]) for c in others[:wrong]]
    share = LoadChooser.fit([*taught, *other_way, *others[wrong:]]).people
    assert 0 < share["yard/p"] < share["yard/q"] < 1
