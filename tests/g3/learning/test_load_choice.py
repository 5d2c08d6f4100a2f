"""Which load a command is about, by all of its words."""

from dataclasses import replace
from math import log

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from g3.learning.load_choice import (
    FEATURES,
    Load,
    LoadChoice,
    LoadChooser,
    features,
    lexicon_of,
)

TIRES, MACHINE, DRUM = ("tire", "pallet"), ("washing", "machine", "pallet"), ("drum",)
NOTHING = lexicon_of([])


def choice(text, *loads, right=(), scenario="s"):
    return LoadChoice(tuple(text.lower().split()), loads, right, "yard", scenario)


def column(name, own):
    return features(own, NOTHING)[:, FEATURES.index(name)].tolist()


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
    assert not LoadChooser.fit(alone).weights.any()
    assert LoadChooser.fit(alone).lexicon.words


def test_stronger_regularisation_gives_smaller_weights():
    weak, strong = (LoadChooser.fit(SEEN, l2=l2).weights for l2 in (0.1, 10.0))
    assert np.linalg.norm(strong) < np.linalg.norm(weak)


words = st.lists(
    st.sampled_from(["speaker", "donuts", "left", "the", "nearest", "zzyzx", "tires"]), max_size=6
)
load = st.builds(
    Load, st.sampled_from((TIRES, MACHINE, DRUM)), st.floats(0, 50), st.floats(-3.14, 3.14)
)


@settings(max_examples=30, deadline=None)
@given(words, st.lists(load, min_size=1, max_size=6))
def test_probabilities_sum_to_one_in_any_order(text, loads):
    learned = LoadChooser.fit(SEEN[:4])
    own = LoadChoice(tuple(text), tuple(loads))
    given_ = np.exp(learned.log_probability(own))
    assert given_.sum() == pytest.approx(1)
    turned = replace(own, loads=tuple(reversed(loads)))
    assert np.exp(learned.log_probability(turned))[::-1] == pytest.approx(given_)
