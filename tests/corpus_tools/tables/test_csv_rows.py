"""CSV: all that Python and pandas write is read as it was, and no mark merges rows."""

from __future__ import annotations

import csv
import io

import pytest
from hypothesis import given
from hypothesis import strategies as st

from corpus_tools.tables.table_reading import csv_rows
from g3.errors import FormatError

# Neither a NUL, which decoding refuses, nor half a surrogate pair, which no file has.
TEXTS = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=8)
AWKWARD = st.text(st.sampled_from(['"', ",", ";", "\n", "\r", " ", "a", "\u2028", "\x85", "\x0b"]))
ROWS = st.lists(st.lists(TEXTS | AWKWARD, min_size=1, max_size=4), max_size=5)


def cells(text: str) -> list[list[str]]:
    return [list(row.cells) for row in csv_rows(text, "t.csv")]


@given(ROWS, st.sampled_from(["\r\n", "\n"]), st.sampled_from([csv.QUOTE_ALL, csv.QUOTE_MINIMAL]))
def test_what_python_writes_is_read_to_the_same_cells(
    rows: list[list[str]], end: str, quoting: int
) -> None:
    if end == "\n" and quoting == csv.QUOTE_MINIMAL:  # before 3.13 Python leaves "\r" bare there
        rows = [[cell.replace("\r", "") for cell in row] for row in rows]
    out = io.StringIO()
    writer = csv.writer(out, lineterminator=end, quoting=quoting)
    writer.writerow(["a", "b"])
    writer.writerows(rows)
    assert cells(out.getvalue()) == [["a", "b"], *rows]


@given(ROWS)
def test_carriage_returns_end_rows_of_old_macs(rows: list[list[str]]) -> None:
    out = io.StringIO()
    csv.writer(out, lineterminator="\r", quoting=csv.QUOTE_ALL).writerows([["a"], *rows])
    assert cells(out.getvalue()) == [["a"], *rows]


@given(st.lists(st.tuples(AWKWARD, TEXTS), min_size=1, max_size=5))
def test_what_pandas_writes_is_read_to_the_same_cells(rows: list[tuple[str, str]]) -> None:
    pandas = pytest.importorskip("pandas")
    plain = [tuple(cell.replace("\r", "") for cell in row) for row in rows]
    text = pandas.DataFrame(plain, columns=["a", "b"]).to_csv(index=False, lineterminator="\n")
    assert cells(text) == [["a", "b"], *map(list, plain)]


ONE_LINE = st.text(st.characters(exclude_characters="\0\n\r", exclude_categories=["Cs"]))


@given(st.lists(st.tuples(ONE_LINE, ONE_LINE), min_size=1, max_size=5), st.data())
def test_a_lone_mark_never_merges_rows(rows: list[tuple[str, str]], data: st.DataObject) -> None:
    out = io.StringIO()
    csv.writer(out).writerows([("a", "b"), *rows])
    text = out.getvalue()
    at = data.draw(st.integers(0, len(text)))
    with pytest.raises(FormatError):
        cells(f'{text[:at]}"{text[at:]}')
    marks = [i for i, letter in enumerate(text) if letter == '"']
    if marks:
        gone = data.draw(st.sampled_from(marks))
        with pytest.raises(FormatError):
            cells(text[:gone] + text[gone + 1 :])


@pytest.mark.parametrize(
    ("text", "where", "what"),
    [
        ('a,b\n1,"Lift the lid\n2,Go.\n', "t.csv:2:3", "not closed"),
        ('a,b\n1,"Lift\n2,"Go."\n', "t.csv:3:4", "line 2, column 3"),
        ('a,b\n1,"Push" the cup\n', "t.csv:2:9", "after the quotation mark"),
        ('a,b\n1,a 5" pipe\n', "t.csv:2:6", "does not begin"),
        ('a,b\n"x\ny",z"\n', "t.csv:3:5", "does not begin"),
        ('a,b\r1,"', "t.csv:2:3", "not closed"),
    ],
)
def test_a_stray_mark_is_named_with_its_place(text: str, where: str, what: str) -> None:
    with pytest.raises(FormatError) as caught:
        cells(text)
    assert caught.value.where == where
    assert what in caught.value.what


def test_cells_know_their_lines() -> None:
    text = 'a,b\r\n"x\r\ny",z\r\n\r\n""\r\n1,2\r\r\n'
    rows = list(csv_rows(text, "t.csv"))
    assert [row.cells for row in rows] == [("a", "b"), ("x\r\ny", "z"), (), ("",), ("1", "2")]
    assert [(row.line, row.last_line) for row in rows] == [(1, 1), (2, 3), (4, 4), (5, 5), (6, 6)]
    assert rows[1].places == ((2, 1), (3, 4))


def test_a_cell_may_be_long() -> None:
    assert cells(f'a\n"{"x" * 200_000}"\n')[1] == ["x" * 200_000]
