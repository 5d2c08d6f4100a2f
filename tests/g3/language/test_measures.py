"""Lengths, angles and times that words say."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from g3.language.lexicon.measures import is_amount, metres_said, radians_said, seconds_said


@pytest.mark.parametrize(
    ("text", "metres"),
    [
        ("10m", 10),
        ("six feet", 1.8288),
        ("a metre", 1),
        ("a metre and a half", 1.5),
        ("two metres and a half", 2.5),
        ("three and a half meters", 3.5),
        ("a few yards", 3 * 0.9144),
        ("a couple of meters", 2),
        ("forty-five cm", 0.45),
        ("1,5 m", 1.5),
        ("one hundred and twenty feet", 36.576),
        ("half a metre", 0.5),
        ("the second meter", None),
        ("two crates", None),
        ("", None),
    ],
)
def test_lengths_are_in_metres(text, metres):
    found = metres_said(text.split())
    assert found == (None if metres is None else pytest.approx(metres))


@pytest.mark.parametrize(
    ("text", "degrees"),
    [
        ("90°", 90),
        ("45deg left", 45),
        ("one hundred eighty degrees", 180),
        ("one hundred and eighty degrees", 180),
        ("three quarters of a turn", 270),
        ("half a turn", 180),
        ("a full circle", 360),
        ("turn right a quarter", 90),
        ("spin 180", 180),
        ("make a turn to the left", None),
        ("turn left and go 10 m", None),
        ("turn to crate 2", None),
    ],
)
def test_angles_are_in_radians(text, degrees):
    found = radians_said(text.split())
    assert found == (None if degrees is None else pytest.approx(np.deg2rad(degrees)))


@given(st.integers(1, 199), st.sampled_from(["m", "metres", "meters"]))
def test_digits_say_what_they_are(number, unit):
    assert metres_said(["about", str(number), unit]) == number
    assert metres_said([f"{number}{unit}"]) == number
    assert seconds_said([str(number), "seconds"]) == number


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("10 m", True),
        ("a quarter turn", True),
        ("180", True),
        ("ten seconds", False),
        ("two", False),
        ("a few", False),
        ("a 10 foot container", False),
        ("crate 12", False),
    ],
)
def test_what_a_noun_measures_is_no_thing(text, says):
    assert is_amount(text.split()) is says
