from __future__ import annotations

import json
from pathlib import Path

import pytest

from corpus_tools.cli.console import run
from corpus_tools.corpus.corpus_model import Corpus
from g3.sdc.clauses import breadth_first
from tests.examples.installed import EXAMPLES, install

SETS = ("table-pair", "table-theme", "table-goal", "table-path")
WITH = [part for name in SETS for part in ("--with", name)]
SETTINGS = {"tables": 10, "commands": 3, "seed": 2}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("blocks")


@pytest.fixture(scope="module")
def ct(folder):
    (folder / "blocks.json").write_text(json.dumps(SETTINGS))
    return install("tabletop_blocks", folder).ct


@pytest.fixture(scope="module")
def corpus(folder, ct):
    done = ct("import", "tabletop-blocks", "blocks.json", "--out", "blocks")
    assert done.returncode == 0, done.stderr
    return Corpus.load(folder / "blocks")


@pytest.fixture(scope="module")
def scores(ct, corpus):
    measure = ["eval", "--table", "1", "--split", "scenario", "--corpus", "blocks"]
    done = ct(*measure, *WITH, "--format", "json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_the_importer_makes_a_corpus_that_says_what_it_is(corpus):
    scenarios = {command.scenario for command in corpus.commands.values()}
    assert len(scenarios) == SETTINGS["tables"]
    assert "no people" in corpus.source
    assert {command.subject for command in corpus.commands.values()} == {"generated"}


def test_no_forklift_is_in_it(corpus):
    labels = {label for c in corpus.contexts.values() for o in c.objects for label in o.labels}
    assert {"hand", "table", "tray", "block", "bar"} < labels
    assert "forklift" not in labels


def test_what_is_right_is_where_the_hand_puts_it(corpus):
    puts = 0
    for annotation in corpus.annotations:
        if annotation.id.endswith("/positive") and "PLACE" in [s.type for s in _nodes(annotation)]:
            place = next(g[0] for g, s in _pairs(annotation) if s.type == "PLACE")
            theme = next(g[0] for g, s in _pairs(annotation) if s.type == "OBJECT" and g)
            end = theme.trajectory.xyz[-1]
            assert end[:2] == pytest.approx(place.prism.xy.mean(axis=0))
            assert end[2] == pytest.approx(place.prism.z_min)
            puts += 1
    assert puts > 5


def test_table_1_is_measured_with_its_own_features(scores):
    rows = {row["type"]: row for row in scores["rows"]}
    assert rows["overall"]["f"] > 0.8
    assert scores["added"] == list(SETS)


def test_a_model_that_needs_the_example_says_so_without_it(folder, ct, corpus, capfd):
    train = ["train", "g3", "--corpus", "blocks", "--with", "table-pair", "--out", "blocks.npz"]
    assert ct(*train).returncode == 0
    model, data = str(folder / "blocks.npz"), str(folder / "blocks")
    assert run(["eval", "--table", "1", "--model", model, "--test", data]) == 2
    assert "table-pair" in capfd.readouterr().err


def test_other_domains_keep_their_default_features(ct):
    listed = json.loads(ct("features", "list", "--format", "json").stdout)["feature_sets"]
    assert {s["name"] for s in listed if not s["default"]} >= set(SETS)


def test_a_settings_file_that_is_wrong_is_one_line(folder, ct):
    (folder / "wrong.json").write_text('{"tables": 3}')
    done = ct("import", "tabletop-blocks", "wrong.json", "--out", "wrong")
    assert done.returncode == 2
    assert done.stderr.startswith("ct: error: wrong.json")
    assert len(done.stderr.splitlines()) == 1


def test_the_examples_settings_are_those_of_its_readme():
    settings = json.loads((EXAMPLES / "tabletop_blocks" / "blocks.json").read_text())
    readme = (EXAMPLES / "tabletop_blocks" / "README.md").read_text()
    made = f"{settings['tables']} tables, {settings['tables'] * settings['commands']} commands"
    assert made in readme


def _nodes(annotation):
    return list(breadth_first(annotation.sdcs))


def _pairs(annotation):
    return zip(annotation.groundings, _nodes(annotation), strict=True)
