"""``ct eval`` through the command line, on a tiny corpus."""

from __future__ import annotations

import csv
import io
import json
import subprocess
import sys

import numpy as np
import pytest

from corpus_tools.cli.console import run
from corpus_tools.corpus.corpus_model import Corpus
from eval.table_1.correspondence import ROW_TYPES
from eval.table_1.held_out_predictions import curve_sizes
from g3.features.feature_registry import select
from g3.learning.examples import examples
from g3.learning.factor_matrix import matrix_of_examples
from g3.learning.grounding_model import GroundingModel
from tests.tiny_corpus import SCENARIOS, tiny_corpus

CV = ["--corpus", "tiny", "--cv", "scenario"]
METADATA = {
    "program",
    "catalogue_version",
    "protocol",
    "negatives",
    "threshold",
    "seed",
    "test_examples",
}


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A folder with a corpus of all scenarios, and two of some; every test runs in it."""
    monkeypatch.chdir(tmp_path)
    tiny_corpus().save(tmp_path / "tiny")
    tiny_corpus(SCENARIOS[:2]).save(tmp_path / "two")
    tiny_corpus(SCENARIOS[2:]).save(tmp_path / "third")
    return tmp_path


def ct(*arguments):
    return run(["eval", *arguments])


@pytest.fixture
def output(capsys):
    """Runs ``ct eval``, which must succeed, and gives what it prints."""

    def output(*arguments):
        status = ct(*arguments)
        printed = capsys.readouterr()
        assert (status, printed.err) == (0, "")
        return printed.out

    return output


@pytest.fixture
def table(output):
    return lambda *arguments: json.loads(output("--table", "1", *arguments, "--format", "json"))


# Table 1


def test_cross_validation_tests_every_example_once(table):
    content = table(*CV)
    assert content.keys() >= METADATA | {"corpus", "ablated", "added", "l2", "draws"}
    assert [row["type"] for row in content["rows"]] == list(ROW_TYPES)
    assert {row["type"]: row["n"] for row in content["rows"]} == {
        "OBJECT": 20,
        "PLACE": 4,
        "PATH": 8,
        "EVENT": 12,
        "overall": 44,
    }
    assert content["corpus"] == tiny_corpus().hash
    assert content["test_scenarios"] == sorted(SCENARIOS)
    assert content["test_examples"] == {"positive": 22, "random": 22}
    for row in content["rows"]:
        assert row.keys() >= {"precision", "recall", "f", "accuracy", "f_low", "f_high", "paper"}
        assert row["positives"] * 2 == row["n"]


def test_any_number_of_jobs_gives_the_same_table(table):
    assert table(*CV, "--draws", "600", "--jobs", "2") == table(*CV, "--draws", "600")


def test_held_out_scenarios(table, folder):
    content = table("--corpus", "tiny", "--split", "scenario", "--test-scenarios", "to_truck")
    assert content["test_scenarios"] == ["to_truck"]
    assert content["train_examples"] == {"positive": 15, "random": 15}
    assert content["test_examples"] == {"positive": 7, "random": 7}
    (folder / "list").write_text("to_truck\n")
    assert table("--corpus", "tiny", "--test-scenarios", "list") == content


def test_a_split_is_drawn_with_the_seed(table):
    first = table("--corpus", "tiny", "--split", "scenario")
    assert len(first["test_scenarios"]) == 1
    assert first == table("--corpus", "tiny")
    drawn = {table("--corpus", "tiny", "--seed", str(s))["test_scenarios"][0] for s in (1, 2, 3)}
    assert len(drawn) > 1


def test_two_corpora_give_what_the_same_split_gives(table):
    two = table("--train", "two", "--test", "third")
    one = table("--corpus", "tiny", "--test-scenarios", "put_on_truck")
    assert two["rows"] == one["rows"]
    assert two["train_examples"] == one["train_examples"]
    assert two["train_corpus"] == tiny_corpus(SCENARIOS[:2]).hash
    assert two["test_corpus"] == tiny_corpus(SCENARIOS[2:]).hash


def test_a_trained_model_gives_what_training_anew_gives(table, capsys):
    assert run(["train", "g3", "--corpus", "two", "--out", "m", "--l2", "0.5"]) == 0
    capsys.readouterr()
    content = table("--model", "m.npz", "--test", "third")
    assert content["rows"] == table("--train", "two", "--test", "third", "--l2", "0.5")["rows"]
    assert content["l2"] == 0.5
    assert content["train_corpus"] == tiny_corpus(SCENARIOS[:2]).hash
    assert content["model_training"]["corpus"] == "tiny"


def test_the_same_name_of_another_world_is_another_scenario(table, folder):
    tiny_corpus(shift=3.0).save(folder / "elsewhere")
    assert table("--train", "tiny", "--test", "elsewhere")["rows"][-1]["n"] == 44


def test_hard_negatives_replace_the_others_and_do_not_depend_on_the_split(table):
    whole = table(*CV, "--negatives", "hard")
    assert set(whole["test_examples"]) == {"positive", "hard"}
    assert whole["negatives"] == "hard"
    parts = [
        table("--corpus", "tiny", "--test-scenarios", name, "--negatives", "hard")
        for name in SCENARIOS
    ]
    assert sum(p["test_examples"]["hard"] for p in parts) == whole["test_examples"]["hard"]
    assert whole == table(*CV, "--negatives", "hard")


def test_other_negatives_than_those_trained_on_can_be_tested(table):
    both = table(*CV, "--test-negatives", "hard")
    hard = table(*CV, "--negatives", "hard")
    assert (both["negatives"], both["test_negatives"]) == ("random", "hard")
    assert both["test_examples"] == hard["test_examples"]
    assert [r["n"] for r in both["rows"]] == [r["n"] for r in hard["rows"]]
    split = ("--corpus", "tiny", "--test-scenarios", SCENARIOS[0])
    held_out = table(*split, "--test-negatives", "hard")
    assert set(held_out["train_examples"]) == {"positive", "random"}
    assert set(held_out["test_examples"]) == {"positive", "hard"}


def test_feature_sets_can_be_left_out_and_added(table):
    every = [s.name for s in select()]
    chosen = [argument for name in every for argument in ("--ablate", name)]
    nothing = table(*CV, *chosen, "--with", "avs-log")
    assert nothing["ablated"] == every
    assert nothing["added"] == ["avs-log"]
    assert nothing["rows"] != table(*CV)["rows"]


def test_potentials_leave_table_1_as_it_is(table, capsys):
    assert ct("--table", "1", *CV, "--ablate", "side", "--format", "json") == 0
    told = capsys.readouterr()
    assert "Table 1 makes no plans, so it is the same without side" in told.err
    found = json.loads(told.out)
    assert found["ablated"] == ["side"]
    assert found["rows"] == table(*CV)["rows"]


def test_the_threshold_decides_what_is_predicted(table):
    every = table(*CV, "--threshold", "0")["rows"][-1]
    assert (every["recall"], every["precision"]) == (1.0, 0.5)
    none = table(*CV, "--threshold", "1")["rows"][-1]
    assert (none["recall"], none["precision"]) == (0.0, None)


@pytest.mark.parametrize("form", ["text", "json", "csv", "latex"])
def test_every_format_records_the_run_and_can_go_to_a_file(output, folder, form):
    arguments = ["--table", "1", *CV, "--format", form, "--seed", "7"]
    text = output(*arguments)
    assert tiny_corpus().hash in text
    assert output(*arguments, "--out", "file") == ""
    assert (folder / "file").read_text() == text
    if form == "csv":
        records = list(csv.DictReader(io.StringIO(text)))
        assert [r["type"] for r in records] == list(ROW_TYPES)
        assert {r["seed"] for r in records} == {"7"}


# The learning curve and the error lists


@pytest.mark.parametrize("protocol", [["--cv", "scenario"], [], ["--split", "scenario"]])
def test_the_learning_curve_is_a_plot_and_a_csv(output, folder, protocol):
    arguments = ["--learning-curve", "--corpus", "tiny", *protocol, "--repeats", "2"]
    assert output(*arguments, "--out", "c.png") == "wrote c.png and c.csv\n"
    assert (folder / "c.png").read_bytes().startswith(b"\x89PNG")
    records = list(csv.DictReader((folder / "c.csv").read_text().splitlines()))
    assert {r["type"] for r in records} == set(ROW_TYPES)
    assert {r["repeats"] for r in records} == {"2"}
    assert json.loads(output(*arguments, "--out", "d.svg", "--json"))["files"] == ["d.svg", "d.csv"]
    assert (folder / "d.csv").read_text() == (folder / "c.csv").read_text()


def test_sizes_of_a_learning_curve_double_up_to_all():
    assert curve_sizes(30) == (30,)
    assert curve_sizes(1128) == (50, 100, 200, 400, 800, 1128)
    assert curve_sizes(1000) == (50, 100, 200, 400, 1000)


def test_error_lists(output):
    content = json.loads(output("--errors", *CV, "--top", "1", "--format", "json"))
    assert content.keys() >= METADATA | {"lists", "top"}
    assert sum(one["examples"] for one in content["lists"]) == 44
    assert all(len(one["phrases"]) <= 1 for one in content["lists"])
    ids = {phrase["id"] for one in content["lists"] for phrase in one["phrases"]}
    assert any(name.endswith("/positive, clause 1") for name in ids)
    assert "-scoring (phrases: 1, of" in output("--errors", *CV, "--top", "1")


# Features once for all splits are as good as features for each


def test_slicing_gives_what_training_on_the_slice_gives():
    items = examples(tiny_corpus().annotations)
    factors = matrix_of_examples(items, select())
    test = np.flatnonzero([e.annotation.command.scenario == "to_truck" for e in items])
    train = np.setdiff1d(np.arange(len(items)), test)
    expected = (
        GroundingModel(l2=0.7)
        .fit([items[i] for i in train])
        .predict_proba([items[i] for i in test])
    )
    found = GroundingModel(l2=0.7).fit(factors[train]).predict_proba(factors[test])
    assert found == pytest.approx(expected, abs=1e-4)


# What is refused


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "Usage: ct eval COMMAND"),
        (["--table", "1", "--errors", *CV], "Give one of table1 and errors"),
        (["--table", "2", *CV], "--cv doesn't go with table2"),
        (["--table", "3", *CV], "--corpus doesn't go with table3"),
        (["--table", "9", *CV], "No such command 'table9'"),
        (["--table", "1"], "Give --corpus; or --corpus and --cv; or --train and --test; or --"),
        (["--table", "1", "--cv", "scenario"], "Give --corpus"),
        (["--table", "1", "--train", "two"], "--train and --test"),
        (["--table", "1", "--test", "two"], "--model and --test"),
        (["--table", "1", "--corpus", "tiny", "--test", "two"], "Give --corpus"),
        (
            ["--table", "1", *CV, "--split", "scenario"],
            "--split doesn't go with --corpus and --cv.",
        ),
        (["--table", "1", *CV, "--test-scenarios", "a"], "--test-scenarios doesn't go"),
        (
            ["--table", "1", "--train", "two", "--test", "third", "--cv", "scenario"],
            "Give --corpus",
        ),
        (["--table", "1", "--model", "m", "--test", "two", "--l2", "1"], "--l2 doesn't go"),
        (["--table", "1", *CV, "--with", "smell"], "there is no feature set 'smell'"),
        (["--table", "1", *CV, "--ablate", "smell"], "no feature set or potential 'smell'"),
        (["--table", "1", *CV, "--top", "3"], "--top doesn't go with table1"),
        (["--table", "1", *CV, "--repeats", "3"], "--repeats doesn't go with table1"),
        (["--errors", *CV, "--draws", "3"], "--draws doesn't go with errors"),
        (["--errors", *CV, "--format", "csv"], "'csv' is not one of 'text', 'json'"),
        (["--learning-curve", *CV], "Missing option '--out'"),
        (["--learning-curve", *CV, "--out", "c.eps"], "The curve needs --out"),
        (["--learning-curve", *CV, "--out", "c.png", "--format", "csv"], "'csv' is not"),
        (
            ["--learning-curve", "--model", "m", "--test", "two", "--out", "c.png"],
            "--model doesn't go with",
        ),
        (["--table", "1", *CV, "--out", "no/file"], "there is no such folder"),
        (["--table", "1", *CV, "--l2", "0"], "--l2"),
        (["--table", "1", "--corpus", "nowhere"], "there is no folder or bundled corpus"),
        (["--table", "1", "--corpus", "tiny", "--test-scenarios", "x"], "give one of put_on"),
        (
            ["--table", "1", "--corpus", "tiny", "--test-scenarios", ",".join(SCENARIOS)],
            "there are no examples to train on",
        ),
        (["--table", "1", "--corpus", "third", "--cv", "scenario"], "no examples to train on"),
        (["--table", "1", "--corpus", "third"], "no examples to train on"),
        (
            ["--table", "1", "--train", "two", "--test", "tiny"],
            "ct: error: tiny: scenario 'to_pallet' is on the training side too (2 such in all)",
        ),
        (["--table", "1", "--model", "m", "--test", "two"], "m.json: the model can't be read"),
    ],
)
def test_bad_input_is_told(capsys, folder, arguments, message):
    before = sorted(folder.iterdir())
    assert ct(*arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert message in printed.err
    if printed.err.startswith("ct:"):
        assert printed.err.count("\n") == 1
    assert sorted(folder.iterdir()) == before


def test_a_model_is_not_tested_on_its_own_scenarios(capsys):
    assert run(["train", "g3", "--corpus", "tiny", "--out", "m"]) == 0
    assert ct("--table", "1", "--model", "m", "--test", "third") == 2
    assert "third: scenario 'put_on_truck' is on the training side too" in capsys.readouterr().err


@pytest.mark.parametrize("negatives", ["random", "hard"])
def test_a_corpus_without_examples_is_told(capsys, folder, negatives):
    commands = tiny_corpus().commands.values()
    Corpus.build("none", contexts=[], commands=commands, annotations=[]).save(folder / "none")
    assert ct("--table", "1", "--corpus", "none", "--negatives", negatives) == 2
    message = capsys.readouterr().err
    assert "corpus none: no clause is grounded and labelled" in message
    assert message.count("\n") == 1


def test_the_command_is_cheap_to_load():
    heavy = "{'numpy', 'scipy', 'rich', 'matplotlib', 'pandas'}"
    code = f"import sys, eval.cli.eval_commands; sys.exit(bool({heavy} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_table_1_loads_nothing_of_inference():
    code = (
        "import sys; from corpus_tools.cli.console import run\n"
        f"status = run(['eval', '--table', '1', *{CV}])\n"
        "sys.exit(status or any(name.startswith('g3.inference') for name in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
