"""``ct simulate-workers``."""

from __future__ import annotations

import json

import pytest

from corpus_tools.cli.console import run
from corpus_tools.importers.authored.bundled import open_corpus


@pytest.fixture
def ct(capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)

    def ct(*arguments):
        status = run(list(arguments))
        printed = capsys.readouterr()
        return status, printed.out, printed.err

    return ct


@pytest.mark.slow
def test_a_dataset_that_is_a_corpus(ct, tmp_path):
    options = ("--commands", "3", "--workers", "4", "--seed", "5", "--out", "made")
    status, out, err = ct("simulate-workers", "describe", "--scenarios", "2", *options, "--json")
    assert (status, err) == (0, "")
    told = json.loads(out)
    assert (told["commands"], told["scenarios"], told["failed"]) == (6, 2, [])
    corpus = open_corpus(tmp_path / "made")
    assert "Simulated" in corpus.source
    assert len(corpus.commands) == 6
    assert all(c.subject.startswith("simulated-") for c in corpus.commands.values())

    # Another run does only what is missing, and changes nothing, whoever does it.
    before = {p: (p.read_bytes(), p.stat().st_mtime_ns) for p in (tmp_path / "made/logs").iterdir()}
    (tmp_path / "made/scenarios/generated-5-0001.yaml").unlink()
    again = ("simulate-workers", "describe", "--scenarios", "2", *options, "--jobs", "2")
    assert ct(*again)[0] == 0
    assert before == {p: (p.read_bytes(), p.stat().st_mtime_ns) for p in before}
    assert open_corpus(tmp_path / "made").hash == corpus.hash

    assert ct("simulate-workers", "rate", "--corpus", "made", "--out", "rated")[0] == 0
    status, out, _ = ct("eval", "--table", "2", "--corpus", "rated", "--format", "json")
    assert status == 0
    assert json.loads(out)["judged_by"] == "simulated raters"


def test_mistakes(ct, tmp_path):
    (tmp_path / "full").mkdir()
    (tmp_path / "full/mine.txt").write_text("keep")
    status, _, err = ct("simulate-workers", "describe", "--scenarios", "1", "--out", "full")
    assert status == 2
    assert "holds something else" in err
    assert [p.name for p in (tmp_path / "full").iterdir()] == ["mine.txt"]

    status, _, err = ct("simulate-workers", "describe", "--workers", "3", "--out", "few")
    assert status == 2
    assert "3 workers" in err

    status, _, err = ct("simulate-workers", "rate", "--corpus", "nowhere", "--out", "rated")
    assert status == 2
    assert "nowhere" in err
