"""``ct eval subtasks``: models' steps against people's corrections."""

from __future__ import annotations

from pathlib import Path

import pytest

from corpus_tools.cli.console import run

HEADER = "answer,video,model,suggestion,state,decided,moved_s,text_distance"


def table(folder: Path, *rows: str) -> str:
    file = folder / "steps.csv"
    file.write_text("\n".join((HEADER, *rows)) + "\n")
    return str(file)


def test_figures_to_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    rows = [
        "1,a,m,shown,unchanged,False,,0", "1,a,m,shown,boundary moved,True,-0.5,0",
        "1,a,m,shown,added,True,,", "2,b,m,shown,text changed,True,0,0.25",
        "2,b,m,shown,removed,True,,", "3,b,n,not shown,unchanged,False,,0",
    ]  # fmt: skip
    assert run(["eval", "subtasks", table(tmp_path, *rows)]) == 0
    cells = [
        [cell.strip() for cell in line.split("|")] for line in capsys.readouterr().out.splitlines()
    ]
    figures = {row[0]: row[1:] for row in cells if len(row) == 3}
    assert figures["measure"] == ["m, shown", "n, not shown"]
    assert figures["undecided"] == ["1", "0"]
    assert figures["accepted"] == ["0.25", "1.00"]
    assert figures["added"] == ["0.25", "0.00"]
    assert figures["text edit distance"] == ["0.08", "0.00"]
    assert figures["boundary error, s"] == ["0.25", "-"]


@pytest.mark.parametrize(
    ("rows", "what"),
    [
        (["1,a,m,shown,lost,,,"], "is no state"),
        (["1,a,m,shown,unchanged,True,soon,0"], "'soon' is no number"),
        (["1,a,m,shown,unchanged,True,nan,0"], "'nan' is no number"),
        (["1,a,m,shown,unchanged,True,0,inf"], "'inf' is no number"),
        ([], "the table has no steps"),
    ],
)
def test_tables_that_are_none(tmp_path: Path, capsys: pytest.CaptureFixture[str], rows, what):
    assert run(["eval", "subtasks", table(tmp_path, *rows)]) == 2
    assert what in capsys.readouterr().err


def test_other_tables(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    (tmp_path / "steps.csv").write_text("video,start_s\na,1\n")
    assert run(["eval", "subtasks", str(tmp_path / "steps.csv")]) == 2
    assert "answer" in capsys.readouterr().err
