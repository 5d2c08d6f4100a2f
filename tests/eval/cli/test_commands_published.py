"""Table 1 on the authors' release, where it is at hand."""

from __future__ import annotations

import json

import pytest

from corpus_tools.cli.console import run
from eval.table_1.correspondence import ROW_TYPES

pytestmark = pytest.mark.slow


def test_table_1(published, tmp_path, capsys):
    corpus, _ = published
    corpus.save(tmp_path / "aaai11")
    # One split, as in the paper; to hold out each scenario in turn takes fifteen times as long.
    arguments = ["--corpus", str(tmp_path / "aaai11"), "--split", "scenario", "--format", "json"]
    assert run(["eval", "--table", "1", *arguments]) == 0
    told = json.loads(capsys.readouterr().out)
    assert len(told["test_scenarios"]) == 5
    rows = told["rows"]
    assert [row["type"] for row in rows] == list(ROW_TYPES)
    assert all(row["n"] > 80 for row in rows)
    overall = rows[-1]
    assert overall["n"] > 1200
    assert overall["f"] > 0.88
    assert overall["f_low"] < overall["f"] < overall["f_high"]
