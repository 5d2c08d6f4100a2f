from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.authored.bundled import open_corpus
from eval.cli.eval_commands import evaluate
from eval.statistics.ratings import check_judgments, of_study, ratings_of, repeated
from eval.table_2.rating_shares import table_2
from eval.table_2.rating_table import COLUMNS, notes, render
from g3.annotation import Judgment
from g3.errors import FormatError


def judgments(seed: int = 0) -> list[Judgment]:
    """Ten videos with three commands each, judged five times with the own and another video."""
    rng = np.random.default_rng(seed)
    found = []
    for video in range(10):
        for command in range(3):
            for shown in (video, (video + 1) % 10):
                for rater in rng.choice(12, 5, replace=False):
                    likely = ("SA", "A", "A", "N") if shown == video else ("SD", "SD", "D", "A")
                    rating = likely[rng.integers(4)]
                    name = f"{len(found):04}"
                    text = f"Do {video} {command}."
                    found.append(
                        Judgment(name, text, f"v{video}", f"v{shown}", rating, f"r{rater}", "main")
                    )
    return found


def made(rows, **options):
    return table_2(rows, **{"seed": 0, "draws": 500, **options})


def test_shares_by_hand():
    rows = [
        Judgment("1", "Go.", "a", "a", "SA", "r1", "s"),
        Judgment("2", "Go.", "a", "a", "A", "r2", "s"),
        Judgment("3", "Go.", "a", "a", "N", "r3", "s"),
        Judgment("4", "Go.", "b", "b", "D", "r1", "s"),
        Judgment("5", "Go.", "b", "a", "SD", "r1", "s"),
        Judgment("6", "Go.", "b", "a", "A", "r2", "s"),
    ]
    original, random = made(rows).rows
    assert (original.share.value, original.n, original.pairs, original.videos) == (0.5, 4, 2, 2)
    assert (original.raters, original.majority) == (3, 0.5)
    # One of two is no majority.
    assert (random.share.value, random.n, random.majority) == (0.5, 2, 0.0)


def test_intervals_hold_the_share_and_repeat():
    rows = judgments()
    results = made(rows)
    for row in results.rows:
        for interval in (row.share, row.two_way, row.wilson, row.exact):
            assert interval.low <= interval.value <= interval.high
    assert render(made(rows), "json", {}) == render(results, "json", {})
    assert results.delta.value > 0.5
    original, random = results.rows
    assert original.weighed.value > random.weighed.value + 0.4
    assert results.alpha.is_known


def test_the_largest_study_counts():
    rows = judgments()
    trial = [replace(j, id=f"t{j.id}", study="trial") for j in rows[:50]]
    results = made([*trial, *rows])
    assert results.study == "main"
    assert results.rows == made(rows).rows
    assert results.left_out["trial"]["judgments"] == 50
    assert made([*trial, *rows], study="trial").study == "trial"
    with pytest.raises(FormatError, match="give one of main, trial"):
        of_study([*trial, *rows], "nothing")
    with pytest.raises(FormatError, match="no judgments"):
        made([])


def test_repeated_judgments_are_counted_and_told():
    rows = judgments()
    again = [*rows, replace(rows[0], id="again")]
    assert (repeated(rows), repeated(again)) == (0, 1)
    assert not any("judged the pair before" in note for note in notes(made(rows)))
    assert any("1 judgments count that are by" in note for note in notes(made(again)))
    assert repeated([*rows, replace(rows[0], id="again", study="other")]) == 0


def test_unknown_videos_are_refused():
    videos = {f"v{number}" for number in range(10)}
    check_judgments(judgments(), videos)
    with pytest.raises(FormatError, match="line 1: no command was typed for the video 'v0'"):
        check_judgments(judgments(), videos - {"v0"})


def test_models():
    results = made(judgments(), models=True)
    assert results.link is not None
    assert results.link.odds_ratio().low > 5
    for row in results.rows:
        assert row.model is not None
        assert row.model.low < row.share.value < row.model.high
        assert row.crossed is not None
        assert row.crossed.low < row.share.value < row.crossed.high
        for form in ("text", "csv", "latex"):
            text = render(results, form, {})
            assert f"{row.model.value:.3f}" in text, form
            assert f"{row.crossed.value:.3f}" in text, form
    assert "GEE" not in render(made(judgments()), "text", {})


def test_it_says_which_videos_are_clusters():
    rows = [j for j in judgments() if j.command_video < "v8"]
    original, random = made(rows).rows
    assert (original.videos, original.shown) == (8, 8)
    assert (random.videos, random.shown) == (8, 8)
    some = [j for j in rows if j.command_video != "v3" or j.shown_video == "v3"]
    assert "(original 8, shown with 8; random 7, shown with 7)" in render(made(some), "text", {})
    assert np.isnan(original.share.low)  # eight videos tell too little
    assert original.two_way.low < original.share.value


def test_one_configuration_alone():
    rows = [j for j in judgments() if j.command_video == j.shown_video]
    results = made(rows, models=True)
    assert [row.configuration for row in results.rows] == ["original"]
    assert results.link is not None
    assert results.link.odds_ratio().reason == results.delta.reason == "empty class"
    assert "random" not in render(results, "csv", {})


def test_a_single_cluster_has_no_models():
    rows = [replace(j, command_video="v0") for j in judgments() if j.command_video == "v0"]
    results = made(rows, models=True)
    assert len(results.rows) == 2
    assert results.link is not None
    assert results.link.odds_ratio().reason == "one cluster"
    assert {row.model.reason for row in results.rows if row.model is not None} == {"one cluster"}


def test_units_are_pairs():
    ratings = ratings_of(judgments())
    assert len(ratings.units()) == 60
    assert sum(map(sum, ratings.units())) == ratings.rating.sum()


@pytest.fixture(scope="module")
def rated_corpus() -> Corpus:
    """An authored corpus with ratings."""
    authored = open_corpus("warehouse")
    videos = sorted({command.video for command in authored.commands.values()})
    rated = [
        replace(
            j, command_video=_as(j.command_video, videos), shown_video=_as(j.shown_video, videos)
        )
        for j in judgments()
    ]
    return replace(authored, judgments=tuple(rated))


@pytest.fixture(scope="module")
def corpus(tmp_path_factory: pytest.TempPathFactory, rated_corpus: Corpus) -> str:
    """A corpus whose commands people typed, with ratings."""
    folder: Path = tmp_path_factory.mktemp("corpora") / "rated"
    typed = {id_: replace(c, subject="A1") for id_, c in rated_corpus.commands.items()}
    replace(rated_corpus, commands=typed, annotations=()).save(folder)
    return str(folder)


def _as(video: str, videos: list[str]) -> str:
    return videos[int(video[1:])]


def run(*options: str) -> str:
    result = CliRunner().invoke(evaluate, options)
    assert result.exit_code == 0, result.output
    return result.output


def test_the_command(corpus: str):
    found = json.loads(run("--table", "2", "--corpus", corpus, "--format", "json"))
    assert found["draws"] == 10_000
    assert [row["configuration"] for row in found["rows"]] == ["original", "random"]
    for row in found["rows"]:
        assert row["low"] < row["precision"] < row["high"]
        assert row["n"] == 150
    rows = list(
        csv.DictReader(io.StringIO(run("--table", "2", "--corpus", corpus, "--format", "csv")))
    )
    assert set(COLUMNS) < set(rows[0])
    text = run("--table", "2", "--corpus", corpus)
    assert "Paper" in text
    assert "judged_by: people" in text
    assert run("--table", "2", "--corpus", corpus, "--jobs", "2") == text
    assert r"\begin{tabular}" in run("--table", "2", "--corpus", corpus, "--format", "latex")


def test_the_papers_figures_are_not_beside_authored_commands(rated_corpus: Corpus, tmp_path: Path):
    rated_corpus.save(tmp_path / "authored")
    text = run("table2", "--corpus", str(tmp_path / "authored"), "--draws", "20")
    assert "judged_by: people" in text
    assert "Paper" not in text
    found = json.loads(run("table2", "--corpus", str(tmp_path / "authored"), "--json"))
    assert [row["paper"] for row in found["rows"]] == [None, None]
    assert "Paper" not in run("table2", "--corpus", str(tmp_path / "authored"), "--format", "latex")


def test_planning(corpus: str):
    found = json.loads(run("--power", "--half-width", "0.02", "--format", "json"))
    assert all(row["half_width"] <= 0.02 for row in found["rows"])
    for form in ("text", "csv", "latex"):
        assert "judges" in run("--power", "--corpus", corpus, "--format", form).casefold()


@pytest.mark.parametrize(
    "options",
    [
        ["table2", "--corpus", "x", "--cv", "scenario"],
        ["table2", "--corpus", "x", "--half-width", "0.1"],
        ["power", "--draws", "5"],
        ["table1", "--corpus", "x", "--models"],
    ],
)
def test_wrong_options(options: list[str]):
    result = CliRunner().invoke(evaluate, options)
    assert result.exit_code == 2
    assert " doesn't go with " in result.output


def test_simulated_ratings_come_with_the_toolkit_and_are_labelled_so():
    text = run("table2", "--draws", "20", "--verbose")
    assert text.startswith("Simulated raters who agree")
    assert "Paper" not in text
    assert all(len(line) <= 100 for line in text.splitlines())
    found = json.loads(run("table2", "--draws", "20", "--json"))
    assert found["judged_by"] == "simulated raters"
    assert [row["paper"] for row in found["rows"]] == [None, None]
