"""Tables of any content fit 100 columns, and lose nothing by it."""

from __future__ import annotations

import re

from hypothesis import given
from hypothesis import strategies as st
from rich.cells import cell_len
from rich.text import Text

from corpus_tools.runtime.text_tables import WIDTH, columns, figure_table, table_lines

CELL = st.text(st.sampled_from("abc xyz-éλ中"), max_size=90)
FIGURE = st.floats(-9999, 9999).map("{:.2f}".format) | st.just("0.71 (0.59-0.83)")


@st.composite
def contents(draw: st.DrawFn) -> tuple[int, list[str], list[list[str]]]:
    """Draw the number of columns of words, headings, and rows."""
    words, figures = draw(st.integers(1, 5)), draw(st.integers(0, 14))
    heading = st.text(st.sampled_from("abc xyz"), max_size=14)
    headings = draw(st.lists(heading, min_size=words + figures, max_size=words + figures))
    row = st.tuples(*[CELL] * words, *[FIGURE] * figures).map(list)
    return words, headings, draw(st.lists(row, max_size=4))


def letters(text: str) -> list[str]:
    return sorted(re.sub(r"[\s|+-]", "", text))


@given(contents(), st.booleans())
def test_any_table_fits_and_loses_nothing(
    content: tuple[int, list[str], list[list[str]]], terminal: bool
) -> None:
    words, headings, rows = content
    table = figure_table(headings, (map(Text, row) for row in rows), words=words)
    lines = [re.sub(r"\x1b\[[0-9;]*m", "", line) for line in table_lines(table, terminal=terminal)]
    assert all(cell_len(line) <= WIDTH for line in lines)
    shown = " ".join(lines)
    for row in rows:
        for figure in row[words:]:
            assert figure in shown  # whole, in one line
        for word in " ".join(row[:words]).split():
            assert not set(letters(word)) - set(letters(shown))
    if "" not in lines[:-1]:  # in one piece
        whole = "".join([*headings, *(cell for row in rows for cell in row)])
        assert letters(shown.replace("─", "")) == letters(whole)


@given(st.integers(1, 6).flatmap(lambda n: st.lists(st.tuples(*[CELL] * n), min_size=1)))
def test_any_columns_of_words_fit(rows: list[tuple[str, ...]]) -> None:
    lines = columns(rows)
    assert all(cell_len(line) <= WIDTH for line in lines)
    assert letters("".join(lines)) == letters("".join(cell for row in rows for cell in row))


def test_figures_without_room_continue_below_beside_the_words() -> None:
    headings = ["measure", *(f"model-{i}" for i in range(20))]
    lines = table_lines(figure_table(headings, [["errors", *["0.50"] * 20]]))
    heads = [line for line in lines if "measure" in line]
    assert len(heads) == len([line for line in lines if "errors" in line]) == 3
    assert re.findall("model-[0-9]+", " ".join(heads)) == headings[1:]


def test_only_words_get_narrower() -> None:
    row = ["1 of 2", "the boxes on the truck " * 4, "yard_unload_boxes-09/positive"]
    lines = table_lines(figure_table(("n", "words", "example"), [row], words=3))
    assert max(map(len, lines)) <= WIDTH
    assert row[2] in " ".join(lines)  # no word is broken
