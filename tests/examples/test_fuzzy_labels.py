"""Somebody else's grounder, parser and judge, installed as pip does it, in Table 3."""

from __future__ import annotations

import json

import pytest

from tests.eval.yard import few_annotated, yards
from tests.examples.installed import install

OTHERS = ("random", "nearest", "keywords", "embeddings", "fuzzy", "counts")
ROWS = (*OTHERS, "auto-top30", "auto-all")


@pytest.fixture(scope="module")
def fuzzy(tmp_path_factory):
    installed = install("fuzzy_labels", tmp_path_factory.mktemp("fuzzy"))
    yards(installed.folder / "source").save(installed.folder / "yards")
    few_annotated().save(installed.folder / "few")
    return installed


def table_3(installed, *more, judge="automatic"):
    asked = ("eval", "--table", "3", "--judge", judge, "--train", "few", "--test", "yards")
    return installed.ct(*asked, "--draws", "20", *more)


@pytest.mark.slow
def test_they_are_rows_beside_the_baselines_and_the_model(fuzzy):
    grounders = ("--grounder", "fuzzy", "--grounder", "counts")
    done = table_3(fuzzy, *grounders, "--parser", "verb-object", "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    rows = {r["configuration"]: r for r in found["rows"] if r["subset"] == "all"}
    assert set(rows) == {*ROWS, "paper", "verb-object"}
    told = {c["text"]: (c["correct"], c["probability"]) for c in found["commands"]["fuzzy"]}
    # Worked by hand: "refrigerator" and "washing machine" are labels as they stand.
    assert told["Pick up the refrigerator."] == (1, 1.0)
    assert told["Put the washing machine on the trailer."] == (1, 1.0)
    assert told["Turn around and go."][0] == 0
    counted = {c["text"]: c["correct"] for c in found["commands"]["counts"]}
    assert counted["Turn around and go."] == 0  # it picks something up
    assert sum(counted.values()) > 0
    assert rows["fuzzy"]["n"] == rows["verb-object"]["n"] == 6
    pairs = {(c["one"], c["other"]) for c in found["comparisons"]}
    assert {("keywords", "fuzzy"), ("fuzzy", "auto"), ("auto", "verb-object")} <= pairs
    modules = {"fuzzy": "fuzzy_labels.fuzzy_grounder", "counts": "fuzzy_labels.counting_grounder"}
    assert found["grounders"] == {name: {"module": module} for name, module in modules.items()}
    assert found["parsers"] == ["verb-object"]


@pytest.mark.slow
def test_another_judge_says_who_it_is(fuzzy):
    done = table_3(fuzzy, judge="same-load")
    assert done.returncode == 0, done.stderr
    assert "all commands   (judge: same-load)" in done.stdout
    assert "by a judge of your choice" in done.stdout
    lines = done.stdout.replace("|", " ").splitlines()[:9]
    (row,) = (line.split() for line in lines if line.startswith("keywords"))
    # "Pick up the washer and put it down." and that alone takes another load.
    assert row[1] == "0.83"


def test_names_that_nobody_has_are_told(fuzzy):
    done = table_3(fuzzy, "--grounder", "ghost")
    assert done.returncode == 2
    assert "there is no grounder 'ghost' (give one of counts, embeddings, fuzzy" in done.stderr
    done = table_3(fuzzy, "--parser", "fuzzy")
    assert "there is no parser 'fuzzy' (give one of verb-object; or install" in done.stderr
