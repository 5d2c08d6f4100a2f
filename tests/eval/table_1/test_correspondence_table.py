from __future__ import annotations

import csv
import io
import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eval.statistics.estimates import FIGURES, Estimate
from eval.table_1.correspondence import PAPER_TABLE_1, ROW_TYPES, Row
from eval.table_1.correspondence_table import COLUMNS, render
from eval.tables.formats import FORMATS, plain

UNDEFINED = Estimate(math.nan, math.nan, math.nan)


def row(kind, estimate=UNDEFINED, n=0):
    return Row(kind, estimate, estimate, estimate, estimate, n, n // 2, n // 4, n // 8)


ROWS = (
    row("OBJECT", Estimate(0.925, 0.8, 1.0), 40),
    row("PLACE", Estimate(0.5, math.nan, math.nan), 8),
    row("PATH"),
    row("EVENT", Estimate(0.25, 0.125, 0.5), 20),
    row("overall", Estimate(0.75, 0.5, 0.875), 68),
)
METADATA = {"corpus": "wärehouse", "seed": 7, "loss": float("nan"), "sizes": np.array([1, 2])}


def refuse_constant(name):
    raise AssertionError(f"{name} is not JSON")


def test_json_is_strict_with_metadata_at_the_top():
    read = json.loads(render(ROWS, "json", METADATA), parse_constant=refuse_constant)
    rows = read.pop("rows")
    assert read == {"corpus": "wärehouse", "seed": 7, "loss": None, "sizes": [1, 2]}
    assert [one["type"] for one in rows] == list(ROW_TYPES)
    assert rows[0]["precision"] == 0.925
    assert (rows[0]["f_low"], rows[0]["f_high"], rows[0]["n"]) == (0.8, 1.0, 40)
    assert rows[2]["accuracy"] is None
    assert rows[3]["paper"] == {
        "precision": 0.84,
        "recall": 0.73,
        "f": 0.78,
        "accuracy": 0.80,
        "source": "Tellex et al. (AAAI 2011), Table 1",
    }


def test_csv_can_be_read_back():
    records = list(csv.DictReader(io.StringIO(render(ROWS, "csv", METADATA))))
    assert list(records[0]) == [*COLUMNS, *METADATA]
    assert [record["type"] for record in records] == list(ROW_TYPES)
    assert float(records[3]["recall_low"]) == 0.125
    assert records[2]["f"] == records[1]["f_low"] == ""
    assert {record["corpus"] for record in records} == {"wärehouse"}
    for record in records:
        for name in FIGURES:
            paper = getattr(PAPER_TABLE_1[record["type"]], name)
            assert record[f"paper_{name}"] == (str(paper) if int(record["n"]) >= 10 else "")


def test_the_papers_figures_are_not_beside_a_handful():
    rows = [row("OBJECT", Estimate(0.9, 0.8, 1.0), 10), row("PLACE", Estimate(0.5, 0.4, 0.6), 9)]
    papers = [one["paper"] for one in json.loads(render(rows, "json", {}))["rows"]]
    assert [one["f"] for one in papers] == [0.94, None]
    text = render(rows, "text", {})
    assert [line.split()[2] for line in text.splitlines() if " paper " in line] == ["0.93", "-"]
    latex = [line for line in render(rows, "latex", {}).splitlines() if "quad paper" in line]
    assert [line.count("0.") for line in latex] == [4, 0]


def test_the_papers_figures_are_not_beside_an_authored_corpus():
    about = {"is_authored": True}
    papers = [one["paper"] for one in json.loads(render(ROWS, "json", about))["rows"]]
    assert {paper[name] for paper in papers for name in FIGURES} == {None}
    for form in ("text", "latex"):
        rows = [line.split() for line in render(ROWS, form, about).splitlines()]
        assert not any(
            "paper" in row[:1] or row[:2] == [r"\quad", "paper$^\\dagger$"] for row in rows
        )
    (record, *_) = csv.DictReader(io.StringIO(render(ROWS, "csv", about)))
    assert {record[f"paper_{name}"] for name in FIGURES} == {""}


def test_table_for_a_file_is_plain_and_fits_80_columns():
    assert render(ROWS, "text", {}).isascii()
    text = render(ROWS, "text", {"corpus": "wärehouse"})
    assert "wärehouse" in text
    assert max(map(len, text.splitlines())) <= 80
    lines = [[field.strip() for field in line.split("|")] for line in text.splitlines()]
    assert ["OBJECT", *["0.93"] * 4, "40", "20", "10"] in lines  # 0.925 in binary is above
    assert ["95%", *["0.80-1.00"] * 4, "", "", ""] in lines
    assert ["paper", "0.93", "0.94", "0.94", "0.91", "", "", ""] in lines
    assert ["PATH", *["-"] * 4, "0", "0", "0"] in lines


def test_table_for_a_terminal_has_styles():
    text = render(ROWS, "text", METADATA, terminal=True)
    assert "\x1b[1m" in text
    assert "0.80–1.00" in text


def test_metadata_cannot_style_or_break_lines():
    text = render(ROWS, "text", {"note": "[bold]x[/]\n\x1b[31mred"}, terminal=True)
    assert "[bold]x[/]  [31mred" in text
    assert "\x1b[31m" not in text


def test_latex_is_a_booktabs_tabular():
    lines = render(ROWS, "latex", {"note": "one\ntwo"}).splitlines()
    assert lines[:2] == [r"% Needs \usepackage{booktabs}.", "% note: one two"]
    body = [line for line in lines if line.endswith(r"\\")]
    assert all(line.count("&") == 5 for line in body)
    assert len(body) == 1 + 2 * len(ROWS)
    assert r"OBJECT & 0.93 {\scriptsize [0.80, 1.00]}" in "\n".join(body)
    assert "PLACE & 0.50 & 0.50 & 0.50 & 0.50 & 8" in "\n".join(body)
    assert "PATH & -- & -- & -- & -- & 0" in "\n".join(body)
    rules = [line for line in lines if line.endswith("rule")]
    assert rules == [r"\toprule", r"\midrule", r"\midrule", r"\bottomrule"]


def test_latex_that_is_handed_on_tells_nothing_of_the_machine(tmp_path):
    about = {"corpus": str(tmp_path / "my corpus"), "url": "https://lab.example.org/a"}
    text = render(ROWS, "latex", about)
    assert "% corpus: my corpus\n% url: https://lab.example.org/a\n" in text
    assert str(tmp_path) not in text
    assert str(tmp_path) in render(ROWS, "json", about)


@pytest.mark.parametrize("name", FORMATS)
def test_no_rows_and_no_final_newline(name):
    text = render((), name, {})
    assert not text.endswith("\n")
    assert text


def test_clashing_metadata_is_refused():
    with pytest.raises(ValueError, match="'rows'"):
        render(ROWS, "json", {"rows": 5})
    with pytest.raises(ValueError, match="'f_low'"):
        render(ROWS, "csv", {"f_low": 5})


def test_unknown_format_is_refused():
    with pytest.raises(ValueError, match="expected one of text, json, csv, latex"):
        render(ROWS, "xml", {})


values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.binary(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner) | st.tuples(inner),
)


@given(values)
def test_plain_values_survive_strict_json(value):
    once = plain(value)
    assert json.loads(json.dumps(once, allow_nan=False)) == once
    assert plain(once) == once
