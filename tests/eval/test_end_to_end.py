"""``ct eval --table 3`` on a few commands of two bundled scenarios."""

import json

import pytest
from click.testing import CliRunner

from corpus_tools.bundled import open_corpus
from corpus_tools.corpus.encoding import make_corpus
from corpus_tools.corpus.writing import write_corpus
from eval.commands import evaluate

SCENARIOS = ("court_put_crate_on_trailer", "hall_pick_up_boxes")


@pytest.fixture(scope="module")
def few(tmp_path_factory):
    whole = open_corpus("warehouse")
    ids = {f"{name}-0{number}" for name in SCENARIOS for number in (1, 2, 3)}
    annotations = [a for a in whole.annotations if a.command.id in ids]
    corpus = make_corpus(
        name="few",
        contexts=list({a.context.id: a.context for a in annotations}.values()),
        commands=list({a.command.id: a.command for a in annotations}.values()),
        annotations=annotations,
        judgments=[],
        source=whole.source,
        licence=whole.licence,
    )
    path = tmp_path_factory.mktemp("corpora") / "few"
    write_corpus(corpus, path)
    return str(path)


@pytest.mark.slow
def test_table_3_says_who_judges_and_how_many(few):
    arguments = ["--table", "3", "--judge", "automatic", "--train", few, "--test", few]
    done = CliRunner().invoke(evaluate, [*arguments, "--format", "json"])
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    assert found["judge"] == "automatic"
    assert sorted(found["test_scenarios"]) == sorted(SCENARIOS)
    rows = {row["configuration"]: row for row in found["rows"]}
    assert set(rows) >= {"random", "gold-top30", "auto-top30", "gold-all"}
    for row in rows.values():
        assert row["n"] == 6
        assert 0 <= row["low"] <= row["precision"] <= row["high"] <= 1
    assert 0 <= found["object_grounding_top1"] <= 1


def test_table_3_needs_to_know_who_judges(few):
    done = CliRunner().invoke(evaluate, ["--table", "3", "--train", few, "--test", few])
    assert done.exit_code == 2
    assert "--judge automatic" in done.stderr
