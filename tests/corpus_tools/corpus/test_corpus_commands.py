from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from corpus_tools.cli.corpus_commands import corpus as corpus_commands
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_statistics import statistics, statistics_of_files
from corpus_tools.importers.authored.bundled import resolve
from g3.errors import CorpusError, FormatError


def run(*args):
    return CliRunner().invoke(corpus_commands, [str(arg) for arg in args])


def test_statistics(small_corpus):
    counted = statistics(small_corpus)
    assert (counted.videos, counted.subjects) == (1, 1)
    assert (counted.commands, counted.commands_typed) == (1, 2)
    assert counted.sdcs == 3
    assert counted.sdcs_by_type == {"EVENT": 1, "OBJECT": 2, "PLACE": 0, "PATH": 0}
    assert counted.implicit == 1
    assert counted.annotations == {"positive": 1}
    examples = counted.examples_by_source["positive"]
    assert (examples.true, examples.false) == (2, 0)
    assert (counted.judgments_same, counted.judgments_different) == (1, 1)
    assert counted.scenarios == ("s",)


def test_files_are_counted_as_the_corpus_that_they_hold(corpus_path):
    for folder in (corpus_path, resolve("warehouse")):
        assert statistics_of_files(folder) == statistics(Corpus.load(folder))


def test_files_that_somebody_has_written_anew_are_read(corpus_path):
    wanted = statistics(Corpus.load(corpus_path))
    path = corpus_path / "commands.jsonl"
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    assert statistics_of_files(corpus_path) == wanted


@pytest.mark.parametrize("name", ["annotations", "commands", "contexts", "judgments"])
def test_files_that_are_damaged_are_not_counted(corpus_path, name):
    path = corpus_path / f"{name}.jsonl"
    content = path.read_bytes()
    for damaged in (content[:-9], content.replace(b"p", b"q"), content + content, b"{}\n"):
        path.write_bytes(damaged)
        with pytest.raises(FormatError):
            statistics_of_files(corpus_path)


def test_stats_as_a_table_has_the_papers_figures(corpus_path):
    rows = {
        line.split("  ")[0]: line.split() for line in run("stats", corpus_path).output.splitlines()
    }
    assert rows["videos"][-2:] == ["1", "22"]
    assert rows["subjects"][-2:] == ["1", "45"]
    assert rows["commands per video"][-2:] == ["1.0", "13"]


def test_stats_of_an_authored_corpus_are_without_the_papers_figures():
    lines = [line.split() for line in run("stats", "warehouse").output.splitlines()]
    assert ["videos", "28"] in lines
    assert json.loads(run("stats", "warehouse", "--json").output)["is_authored"]


def test_stats_as_json(corpus_path):
    counted = json.loads(run("stats", corpus_path, "--format", "json").output)
    assert counted["hash"] == Corpus.load(corpus_path).hash
    assert counted["examples_by_source"]["positive"] == {"true": 2, "false": 0}


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        ([], ["small", "made up", "sha256:", "Pick it up", "s-01/positive"]),
        (["s-01"], ["'Pick it up'", "video v1", "s-01/positive"]),
        (["s-02"], ["annotations: none"]),
        (["s-01/positive"], ["EVENT_1(r = Pick up, l = OBJ_2(f = it))", "(implicit)", "pallet p2"]),
        (["world"], ["robot (agent)", "1 places", "(0.5, 0.5, 0.0) m", "10.4 m in 2 s"]),
    ],
)
def test_show(corpus_path, arguments, parts):
    result = run("show", corpus_path, *arguments)
    assert result.exit_code == 0
    for part in parts:
        assert part in result.output


def test_show_tells_that_an_id_is_unknown(corpus_path):
    result = run("show", corpus_path, "s-99")
    assert isinstance(result.exception, CorpusError)
    assert "s-99" in str(result.exception)


def test_validate_a_sound_corpus(corpus_path):
    result = run("validate", corpus_path)
    assert result.exit_code == 0
    assert "no problems" in result.output


def test_validate_a_broken_corpus(corpus_path):
    path = corpus_path / "judgments.jsonl"
    path.write_text(path.read_text().replace('"SA"', '"sa"').replace('"D"', '"d"'))
    result = run("validate", corpus_path)
    assert result.exit_code == 2
    assert "5 problems" in result.output  # two ratings, the count, the digest and the hash
    problems = json.loads(run("validate", corpus_path, "--format", "json").output)["problems"]
    assert len(problems) == 5
    assert all(problem["fix"] for problem in problems)
