"""``ct eval --table 1 --predictions``: predictions that another program has made, from a file."""

import csv
import io
import json

import numpy as np
import pytest
from click.testing import CliRunner

from corpus_tools.importers.authored.bundled import open_corpus
from eval.cli.eval_commands import evaluate
from eval.table_1.correspondence import Predictions
from eval.table_1.divided_examples import Choices
from eval.table_1.given_predictions import (
    compare_predictions,
    id_of,
    read_predictions,
    write_form,
)
from eval.table_1.held_out_predictions import tested_examples as examples_of
from g3.errors import FormatError
from tests.eval.yard import few_annotated

SCENARIOS = ("court_put_crate_on_trailer", "dock_pick_up_tires", "hall_pick_up_boxes")


@pytest.fixture(scope="module")
def corpus(tmp_path_factory):
    commands = open_corpus("warehouse").commands.values()
    folder = tmp_path_factory.mktemp("corpus") / "few"
    few_annotated({c.id for c in commands if c.scenario in SCENARIOS}).save(folder)
    return str(folder)


@pytest.fixture(scope="module")
def tested(corpus):
    return examples_of(Choices(corpus=corpus, division="cv"))


@pytest.fixture
def form(tested, tmp_path):
    file = tmp_path / "form.jsonl"
    assert write_form(file, tested) == len(tested)
    return [json.loads(line) for line in file.read_text().splitlines()]


def put(lines, path):
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    return path


def filled(form, probability):
    return [{**line, "probability": probability(line)} for line in form]


def test_the_form_shows_the_clause_and_its_groundings(form, tested):
    assert [line["example"] for line in form] == sorted(map(id_of, tested))
    assert all(line["probability"] is None for line in form)
    # Nothing tells which are right: ids of annotations would, and so would their order.
    text = json.dumps(form)
    assert not any(word in text for word in ("positive", "random", "correct", "source"))
    things = [line["groundings"]["figure"][0] for line in form if line["type"] == "OBJECT"]
    assert any("labels" in thing for thing in things)
    assert all("middle" in thing for thing in things)
    ways = [line for line in form if line["type"] == "PATH"]
    assert all(len(line["groundings"]["figure"][0]["poses"][0]) == 4 for line in ways)


def test_probabilities_come_in_the_order_of_the_examples(form, tested, tmp_path):
    node = {id_of(e): e.node for e in tested}
    lines = filled(form, lambda line: node[line["example"]] / 100)
    path = put(lines[::-1], tmp_path / "mine.jsonl")
    assert read_predictions(path, tested).tolist() == [e.node / 100 for e in tested]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda lines: lines[1].update(probability=None), ":2: the prediction of .* isn't filled"),
        (
            lambda lines: lines[1].update(probability=1.5),
            r":2:\d+: probability: expected",
        ),
        (lambda lines: lines.append(lines[0]), r":\d+: .* has a prediction in line 1 already"),
        (lambda lines: lines[2].update(example="moon"), ":3: there is no example 'moon'"),
        (lambda lines: lines.pop(), r"1 of \d+ examples have no prediction, such as"),
        (lambda lines: lines[3].pop("example"), r":4:1: .*missing required field `example`"),
    ],
)
def test_what_is_wrong_in_a_file_is_told_with_its_line(change, said, form, tested, tmp_path):
    lines = filled(form, lambda _: 0.5)
    change(lines)
    path = put(lines, tmp_path / "mine.jsonl")
    with pytest.raises(FormatError, match=said) as error:
        read_predictions(path, tested)
    assert str(path) in str(error.value)


def test_they_are_shown_beside_the_model_and_compared(corpus, tested, tmp_path):
    asked = ["--table", "1", "--corpus", corpus, "--cv", "scenario", "--draws", "50"]
    file = tmp_path / "oracle.jsonl"
    done = CliRunner().invoke(evaluate, [*asked, "--write-tasks", str(file)])
    assert done.output == f"wrote {file}: {len(tested)} tasks\n"
    right = {id_of(e): float(e.correct) for e in tested}
    form = [json.loads(line) for line in file.read_text().splitlines()]
    put(filled(form, lambda line: right[line["example"]]), file)
    wrong = tmp_path / "never.jsonl"
    put(filled(form, lambda _: 0.0), wrong)
    asked += ["--predictions", str(file), "--predictions", str(wrong)]

    done = CliRunner().invoke(evaluate, [*asked, "--json"])
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    assert found["predictions"] == ["oracle", "never"]
    ours = {row["type"]: row for row in found["rows"]}
    oracle = {row["type"]: row for row in found["others"]["oracle"]}
    never = {row["type"]: row for row in found["others"]["never"]}
    assert oracle["overall"]["accuracy"] == 1.0
    assert never["overall"]["recall"] == 0.0
    negatives = sum(not e.correct for e in tested)
    assert never["overall"]["accuracy"] == pytest.approx(negatives / len(tested))
    compared = {(c["one"], c["other"]): c for c in found["comparisons"] if c["type"] == "overall"}
    assert set(compared) == {("g3", "oracle"), ("g3", "never"), ("oracle", "never")}
    mine = compared["g3", "oracle"]
    assert mine["difference"] == pytest.approx(ours["overall"]["accuracy"] - 1)
    assert mine["n"] == len(tested)
    assert all(c["adjusted_p"] >= c["p"] for c in compared.values())

    text = CliRunner().invoke(evaluate, asked).stdout
    for name in ("g3", "oracle", "never"):
        assert f"Performance at predicting the correspondence variable: {name}" in text
    assert "Accuracy compared, overall" in text
    table = CliRunner().invoke(evaluate, [*asked, "--format", "csv"]).stdout
    models = [row["model"] for row in csv.DictReader(io.StringIO(table))]
    assert models == ["g3"] * 5 + ["oracle"] * 5 + ["never"] * 5


def test_models_have_different_names(corpus, tested, form, tmp_path):
    path = put(filled(form, lambda _: 0.5), tmp_path / "g3.jsonl")
    asked = ["--table", "1", "--corpus", corpus, "--cv", "scenario", "--predictions", str(path)]
    done = CliRunner().invoke(evaluate, asked)
    assert "two models of Table 1 are called g3" in str(done.exception)


def test_comparisons_by_hand():
    """Of five examples in two scenarios, two of the first one's are right for one model only."""
    kinds, label = np.array(["OBJECT"] * 5), np.array([True, True, False, True, False])
    where = np.array(["s1", "s1", "s1", "s1", "s2"])

    def said(*probability):
        return Predictions(kinds, label, np.array(probability), where, where)

    both = {"one": said(0.9, 0.5, 0.7, 0.2, 0.1), "other": said(0.9, 0.9, 0.1, 0.9, 0.1)}
    found = compare_predictions(both, threshold=0.5, draws=20, seed=0)
    assert [c.type for c in found] == ["OBJECT", "overall"]  # the others have no examples
    (compared,) = found[0].comparisons
    assert (compared.one, compared.other, compared.n) == ("one", "other", 5)
    assert compared.difference.value == pytest.approx(-2 / 5)
    # All that differ are in one scenario, which is as likely to be for the other model.
    assert compared.p == 1.0
