"""Lines of other people's texts."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from g3.storage.text_lines import place_in, split_lines

LINES = st.lists(st.text(st.characters(exclude_characters="\n\r")))


@given(LINES, st.sampled_from(["\n", "\r\n", "\r"]), st.booleans())
def test_lines_are_those_that_were_written(lines: list[str], end: str, is_ended: bool) -> None:
    text = end.join(lines) + (end if is_ended and lines else "")
    wanted = lines if is_ended or not lines or lines[-1] else lines[:-1]
    assert split_lines(text) == wanted


@pytest.mark.parametrize("inner", ["\u2028", "\u2029", "\x85", "\x0b", "\x0c", "\x1c", "\x1d"])
def test_other_line_ends_are_characters(inner: str) -> None:
    assert split_lines(f"a{inner}b\nc") == [f"a{inner}b", "c"]
    assert place_in(f"a{inner}b\nc", 4) == (2, 1)
    assert place_in(f"a{inner}b\nc", 2) == (1, 3)
