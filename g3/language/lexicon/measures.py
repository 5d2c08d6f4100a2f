"""Lengths, angles and times that are said: "two and a half metres", "a quarter turn", "10 s"."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from math import pi

from g3.language.lexicon.tables import VALUES, WORDS

_PARTS = re.compile(r"\d+(?:[.,]\d+)?|[^\W\d]+|°")
_AND_A = ["and", "a"]
_BETWEEN = WORDS["an"] | WORDS["whole"] | {"of", "more"}
"""What may stand between a number and what it counts: "half a metre", "a quarter of a turn"."""
TEN = 10.0
LEAST_DEGREES = 10.0
"""Without a unit so much and more are degrees, where something turns."""


def metres_said(words: Sequence[str]) -> float | None:
    """Return the length that words state, in metres; None for none.

    >>> metres_said("about five metres to the left of".split()), metres_said(["10ft"])
    (5.0, 3.048)
    >>> metres_said("two and a half meters ahead".split()), metres_said(["half", "a", "metre"])
    (2.5, 0.5)
    >>> metres_said(["to", "the", "left", "of"])
    """
    return _said(_values(words), VALUES["metres"])


def seconds_said(words: Sequence[str]) -> float | None:
    """Return the time that words state, in seconds; None for none.

    >>> seconds_said(["for", "half", "a", "minute"]), seconds_said(["10", "seconds"])
    (30.0, 10.0)
    """
    return _said(_values(words), VALUES["seconds"])


def radians_said(words: Sequence[str]) -> float | None:
    """Return the angle that words about turning state, in radians; None for none.

    >>> round(radians_said("one hundred eighty degrees to the right".split()), 2)
    3.14
    >>> round(radians_said(["a", "quarter", "turn"]), 2), round(radians_said(["180"]), 2)
    (1.57, 3.14)
    >>> round(radians_said("one-eight-zero degrees".split()), 2)
    3.14
    >>> radians_said(["turn", "left"])
    """
    values = _values(words)
    for units in (VALUES["radians"], VALUES["circles"]):
        found = _said(values, units)
        if found is not None:
            return found
    if _said(values, VALUES["metres"]) is not None:
        return None
    # Without a unit: "spin 180", "turn right a quarter".
    degrees = [v * pi / 180 for v in _degrees(values)]
    parts = [
        v * 2 * pi for v in values if not isinstance(v, str) and v in VALUES["fractions"].values()
    ]
    return next(iter(degrees + parts), None)


def _degrees(values: Sequence[float | str]) -> list[float]:
    """Numbers that are degrees without a unit."""
    return [v for v in values if not isinstance(v, str) and v >= LEAST_DEGREES]


def _said(values: Sequence[float | str], units: Mapping[str, float]) -> float | None:
    """The first number that counts one of some units, in what those are in."""
    number: float | None = None
    for value in values:
        if not isinstance(value, str):
            number = value
        elif value in units and number is not None:
            return number * units[value]
        elif number is None and value in (
            WORDS["whole"] if units is VALUES["circles"] else WORDS["an"]
        ):
            number = 1.0
        elif value not in _BETWEEN:
            number = None
    return None


def _values(words: Sequence[str]) -> list[float | str]:
    """Words with the numbers that they say, each of which several may say together."""
    found: list[float | str] = []
    for part in (part for word in words for part in _PARTS.findall(word)):
        value = VALUES["numbers"].get(part)
        if part[0].isdigit():
            value = float(part.replace(",", "."))
        if value is not None and found[-1:] == ["and"] and found[-2:-1] == [100.0]:
            found.pop()  # "one hundred and eighty"
        before = found[-1] if found else ""
        if value is None:
            found.append(part)
        elif part in VALUES["fractions"] and found[-2:] == _AND_A:
            del found[-2:]
            _add(found, value)
        elif isinstance(before, str):
            found.append(value)
        elif part in VALUES["fractions"] or part == "hundred":
            found[-1] = before * value
        elif value < TEN and (before % TEN or not value):
            found[-1] = before * TEN + value  # "one eight zero"
        else:
            found[-1] = before + value
    return found


def _add(found: list[float | str], more: float) -> None:
    """Add to the last number, of which the unit may have been said: "a metre and a half"."""
    for i in range(len(found) - 1, max(len(found) - 3, -1), -1):
        own = found[i]
        if not isinstance(own, str) or own in WORDS["an"]:
            found[i] = (1.0 if isinstance(own, str) else own) + more
            return
    found.append(more)


def is_amount(words: Sequence[str]) -> bool:
    """Check that a noun's words say a length or an angle: "10 m", "a quarter turn", "180".

    >>> is_amount(["10", "m"]), is_amount(["a", "quarter", "turn"]), is_amount(["180"])
    (True, True, True)
    >>> is_amount(["the", "truck"]), is_amount(["two", "crates"])
    (False, False)
    """
    values = _values(words)
    said = [value for value in values if isinstance(value, str)]
    if len(said) == len(values):
        return False
    if WORDS["an"].issuperset(said):  # "lift two" tells how many
        return any(v in (VALUES["fractions"]["quarter"], *_degrees(values)) for v in values)
    return values[-1] in {*VALUES["metres"], *VALUES["radians"], *VALUES["circles"]}
