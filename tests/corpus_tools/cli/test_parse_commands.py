"""``ct parse``, ``ct train parser`` and ``ct eval --sdc`` through the command line."""

from __future__ import annotations

import io
import json
import sys
import xml.etree.ElementTree as ET
from dataclasses import replace

import pytest

from corpus_tools.cli.console import run
from g3.language.parsing.parser import parse
from g3.language.parsing.sdc_parser import SDCParser
from g3.sdc.sdc_notation import format_brackets, from_json, parse_brackets
from tests.shared_cases import case
from tests.tiny_corpus import tiny_corpus

PUT = "Put the pallet on the truck."
TREE = "EVENT_1(r = Put, l = OBJ_2(f = the pallet), l2 = PLACE_3(r = on, l = OBJ_4(f = the truck)))"
UNSURE = "Put the pallet by the truck down."
"""Where "by the truck" is, or where it is put."""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    tiny_corpus().save(tmp_path / "tiny")
    return tmp_path


@pytest.fixture
def ct(capsys):
    """Runs a command and gives its status, standard output and standard error."""

    def ct(*arguments):
        status = run(list(arguments))
        printed = capsys.readouterr()
        return status, printed.out, printed.err

    return ct


@pytest.fixture
def stdin(monkeypatch):
    def give(content):
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(content)))

    return give


def test_brackets(ct):
    assert ct("parse", PUT) == (0, f"{TREE}\n", "")


def test_the_best_trees(ct):
    status, out, err = ct("parse", UNSURE, "--n-best", "3")
    assert (status, err) == (0, "")
    chances = [float(line.split()[2]) for line in out.splitlines() if line.startswith("#")]
    assert 2 <= len(chances) <= 3
    assert chances == sorted(chances, reverse=True)
    assert "l = OBJ_2(f = the pallet), l2 = PLACE_3(r = by" in out


def test_json(ct):
    status, out, _ = ct("parse", UNSURE, "--format", "json", "--n-best", "2")
    record = json.loads(out)
    assert status == 0
    assert (record["text"], record["note"], len(record["trees"])) == (UNSURE, "", 2)
    (where,) = (tree for one in record["trees"] for tree in from_json(one["sdcs"])[0].landmark2)
    assert where.type == "PLACE"
    assert record["trees"][0]["probability"] > record["trees"][1]["probability"]


def test_a_file_of_commands(ct, folder):
    (folder / "commands.txt").write_text(f"{PUT}\n\nWait.\n")
    status, out, _ = ct("parse", "--file", "commands.txt", "--format", "json")
    assert status == 0
    assert [json.loads(line)["text"] for line in out.splitlines()] == [PUT, "Wait."]
    status, out, _ = ct("parse", "--file", "commands.txt")
    assert out.splitlines()[:2] == [f"# {PUT}", TREE]


@pytest.mark.parametrize("inner", ["\u2028", "\x85", "\x0b", "\x0c", "\x1c"])
def test_commands_end_at_line_feeds(ct, folder, inner):
    text = f"Put the pallet{inner}on the truck."
    (folder / "commands.txt").write_bytes(f"{text}\r\nWait.".encode("utf-8-sig"))
    status, out, _ = ct("parse", "--file", "commands.txt", "--format", "json")
    assert status == 0
    assert [json.loads(line)["text"] for line in out.split("\n")[:2]] == [text, "Wait."]


def test_the_given_file_has_one_command(ct):
    file = case("10-jsonl-u2028") / "commands.txt"
    status, out, _ = ct("parse", "--file", str(file), "--format", "json")
    assert status == 0
    assert json.loads(out)["text"] == "Put the pallet\u2028on the truck."


def test_standard_input(ct, stdin):
    stdin(f"{PUT}\n".encode())
    assert ct("parse", "-") == (0, f"{TREE}\n", "")


def test_svg(ct, folder):
    status, _, _ = ct("parse", PUT, "--format", "svg", "--out", "put.svg")
    assert status == 0
    texts = [e.text for e in ET.parse(folder / "put.svg").iter() if e.tag.endswith("text")]
    assert {"EVENT_1", "Put", "OBJECT_3", "the pallet", "PLACE_4", "on"} <= set(texts)


def test_conllu(ct):
    status, out, _ = ct("parse", "Put the tire pallet down.", "--format", "conllu")
    assert status == 0
    lines = out.splitlines()
    assert lines[:2] == ["# sent_id = 1", "# text = Put the tire pallet down."]
    rows = [line.split("\t") for line in lines[2:] if line]
    assert [row[0] for row in rows] == ["1", "2", "3", "4", "5", "6"]
    assert [row[1] for row in rows] == ["Put", "the", "tire", "pallet", "down", "."]
    assert all(len(row) == 10 for row in rows)
    event, thing = "SDC=EVENT_1.r", "SDC=OBJECT_2.f"
    told = [event, thing, thing, thing, f"{event}|SpaceAfter=No", "_"]
    assert [row[9] for row in rows] == told
    assert rows[0][6:8] == ["0", "root"]


def test_what_has_no_tree_is_told(ct):
    assert ct("parse", "") == (0, "\n", "ct: the text has no words\n")
    status, out, _ = ct("parse", " ", "--format", "json")
    assert (status, json.loads(out)["trees"]) == (0, [])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "Give either TEXT"),
        (["go", "--file", "x"], "Give either TEXT"),
        (["--file", "missing.txt"], "can't be read"),
        (["go", "--model", "missing.npz"], "can't be read"),
        (["go", "--format", "svg", "--n-best", "2"], "best tree only"),
    ],
)
def test_bad_use_is_refused(ct, arguments, message):
    status, out, err = ct("parse", *arguments)
    assert (status, out) == (2, "")
    assert message in err


def test_files_that_are_no_text_are_refused(ct, folder):
    (folder / "bad.txt").write_bytes(b"go \xff")
    assert "byte 4 is not UTF-8" in ct("parse", "--file", "bad.txt")[2]
    (folder / "empty.txt").write_bytes(b"\n")
    assert "there are no commands" in ct("parse", "--file", "empty.txt")[2]


def test_a_model_that_is_none_is_refused(ct, folder):
    (folder / "bad.npz").write_bytes(b"nothing")
    status, _, err = ct("parse", "go", "--model", "bad.npz")
    assert status == 2
    assert "bad.npz: the arrays can't be read" in err


@pytest.mark.parametrize("piece", ["(", "😀", "lift it "])
def test_a_command_that_is_too_long_is_refused_before_anything_is_read(ct, folder, piece):
    text = piece * (100_000 // len(piece))
    (folder / "long.txt").write_text(f"go\n{text}\n", encoding="utf-8")
    said = "the text has 100000 characters, the limit is 4000 (shorten it, or give it in parts)"
    nothing = ["--model", "missing.npz"]  # which would be the error, if it were read first
    assert ct("parse", text, *nothing) == (2, "", f"ct: error: TEXT: {said}\n")
    result = ct("parse", "--file", "long.txt", *nothing)
    assert result == (2, "", f"ct: error: long.txt: line 2: {said}\n")
    result = ct("follow", text, "--scenario", "missing")
    assert result == (2, "", f"ct: error: TEXT: {said}\n")


@pytest.mark.usefixtures("short_training")
def test_training_gives_the_same_model_each_time(ct, folder):
    for name in ("a.npz", "b.npz"):
        status, out, err = ct("train", "parser", "--corpus", "tiny", "--out", name)
        assert (status, err) == (0, "")
        assert f"wrote {name}" in out
    assert (folder / "a.npz").read_bytes() == (folder / "b.npz").read_bytes()
    model = SDCParser.load(folder / "a.npz")
    assert model.card_["scenarios"] == sorted(
        {command.scenario for command in tiny_corpus().commands.values()}
    )
    annotation = tiny_corpus().annotations[0]
    learned = parse(annotation.command.text, extractor=model)
    assert format_brackets(learned.sdcs) == format_brackets(annotation.sdcs)


def test_extraction_is_scored(ct):
    status, out, err = ct("eval", "--sdc", "--test", "tiny", "--format", "json")
    assert (status, err) == (0, "")
    record = json.loads(out)
    commands = {a.command.id: a for a in tiny_corpus().annotations}
    assert record["commands"] == len(commands)
    for name in ("typed_f", "untyped_f", "segmentation_f", "exact"):
        assert 0 <= record[name] <= 1
    assert record["typed_f"] <= record["untyped_f"]
    assert len(record["errors"]) == record["commands"] - round(record["exact"] * len(commands))
    for error in record["errors"]:
        gold = commands[error["command"]]
        assert parse_brackets(error["gold"], command=gold.command.text) == gold.sdcs
    assert sum(row["n"] for row in record["types"].values()) == record["constituents"]


@pytest.mark.usefixtures("short_training")
def test_extraction_is_cross_validated(ct):
    status, out, err = ct("eval", "--sdc", "--corpus", "tiny", "--cv", "scenario", "--top", "1")
    assert (status, err) == (0, "")
    assert "cv: scenario" in out
    assert "exact trees:" in out


@pytest.mark.usefixtures("short_training")
def test_a_model_tested_on_what_it_has_seen_is_told(ct):
    ct("train", "parser", "--corpus", "tiny", "--out", "a.npz")
    status, out, err = ct("eval", "--sdc", "--model", "a.npz", "--test", "tiny", "--format", "json")
    assert status == 0
    assert "trained on scenarios that are tested" in err
    assert json.loads(out)["seen_scenarios"]


def test_trained_on_another_corpus(ct, folder):
    corpus = tiny_corpus()
    commands = {
        key: replace(command, scenario=f"other_{command.scenario}")
        for key, command in corpus.commands.items()
    }
    annotations = tuple(replace(a, command=commands[a.command.id]) for a in corpus.annotations)
    renamed = replace(corpus, name="other", commands=commands, annotations=annotations)
    renamed.save(folder / "other")
    arguments = ("eval", "--sdc", "--format", "json", "--test", "tiny", "--train")
    status, out, _ = ct(*arguments, "other")
    assert status == 0
    assert json.loads(out)["exact"] == 1
    status, _, err = ct(*arguments, "tiny")
    assert status == 2
    assert "is in both corpora" in err
    besides = ("eval", "--sdc", "--format", "json", "--corpus", "tiny", "--cv", "scenario")
    status, out, _ = ct(*besides, "--train", "other")
    assert status == 0
    assert json.loads(out)["train"] == "other"
    assert json.loads(out)["exact"] == 1


@pytest.mark.parametrize(
    "arguments",
    [
        ["--sdc"],
        ["--sdc", "--corpus", "tiny"],
        ["--sdc", "--table", "1", "--test", "tiny"],
        ["--sdc", "--test", "tiny", "--l2", "1"],
        ["--sdc", "--test", "tiny", "--format", "csv"],
        ["--sdc", "--test", "tiny", "--ablate", "labels"],
    ],
)
def test_options_that_do_not_go_together_are_refused(ct, arguments):
    assert ct("eval", *arguments)[0] == 2
