"""Table 1 on the authors' release, where it is at hand."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from corpus_tools.cli import run
from corpus_tools.corpus.writing import write_corpus
from corpus_tools.importers.slu_core.assembly import import_slu_core
from eval.correspondence import ROW_TYPES

DATA = Path(__file__).parents[3] / "shared" / "data" / "slu_core" / "data"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not DATA.is_dir(), reason=f"the published corpus is not at {DATA}"),
]


def test_table_1(tmp_path, capsys):
    corpus, _ = import_slu_core(DATA, salt="salt")
    write_corpus(corpus, tmp_path / "aaai11")
    arguments = ["--corpus", str(tmp_path / "aaai11"), "--cv", "scenario", "--format", "json"]
    assert run(["eval", "--table", "1", *arguments]) == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert [row["type"] for row in rows] == list(ROW_TYPES)
    assert all(row["n"] > 200 for row in rows)
    overall = rows[-1]
    assert overall["n"] > 4000
    assert overall["f"] > 0.88
    assert overall["f_low"] < overall["f"] < overall["f_high"]
