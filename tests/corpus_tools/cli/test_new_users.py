"""Eighty mistakes of new users: each is answered with what to write, in a few lines."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import click
import pytest

from corpus_tools.cli.console import cli, run

MISTAKES = [
    # A command in the wrong place, or with another name
    ("table1", "ct eval table1"),
    ("publish", "ct crowd publish"),
    ("evl", "'eval'"),
    ("render --out x", "'render-videos'"),
    ("train sdc --corpus warehouse --out x.npz", "ct train has g3, parser"),
    ("import warehouse --out x", "ct import has authored, lerobot, rlds, robomimic"),
    ("import slu_core data --out x", "'slu-core'"),
    ("--verison", "'--version'"),
    ("eval table 1 --corpus warehouse", "'table1'"),
    ("eval --table 4", "'table1', 'table2', 'table3'"),
    ("eval --tabel 1 --corpus warehouse", "Did you mean '--table'?"),
    ("eval --corpus warehouse", "Name a command before --corpus, which is for table1"),
    ("eval table1 --sdc", "Give one of table1 and sdc"),
    ("scenarios list --verbose", "ct --verbose"),
    ("train --corpus warehouse --out x.npz", "ct train has g3, parser"),
    ("eval table1 --corpus", "ct eval table1 --corpus aaai11"),
    ("eval table1 --train warehouse", "Give --train and --test."),
    ("eval table3 --test warehouse --grounder llm", "--endpoint http"),
    ("scenarios list --layout dock", "ct scenarios list has --dataset"),
    # A text without quotes, or none
    ('graph "Pick up the box"', "`ct parse` makes"),
    ("follow pick up the box", "ct follow 'pick up the box'"),
    ("parse put it down", "ct parse 'put it down'"),
    ("graph pick up", "ct graph 'pick up'"),
    ("follow --scenario dock_pick_up_tires", 'ct follow "Put the tire pallet'),
    ("parse", 'ct parse "Put the pallet'),
    # No world, or another one's name
    ('follow "Pick it up"', "ct scenarios list"),
    ('follow "Pick it up" --scenario warehouse', "ct scenarios list"),
    ('follow "Pick it up" --scenario dock_pick_up_tire', "'dock_pick_up_tires'"),
    ('follow "Pick it up" --context warehouse', "CORPUS:ID"),
    ("scenarios show dock", "'dock_pick_up_tires'"),
    ("render-videos dock --out x", "'dock_pick_up_tires'"),
    # A corpus that isn't there, or hasn't what is needed
    ("eval table1 --corpus warehous", "'warehouse'"),
    ("eval table1", "ct eval table1 --corpus"),
    ("eval table1 warehouse", "ct eval table1 --corpus"),
    ("eval table2 --corpus warehouse", "warehouse-simulated-ratings"),
    ("eval table3", "--test warehouse"),
    ("eval table3 --corpus warehouse", "--corpus doesn't go with table3; it is for table1"),
    ("eval table3 --test warehouse --judge human", "give one of automatic"),
    ("corpus validate nothere", "give one of treebank, warehouse"),
    ("corpus show warehouse nothere", "lists the scenarios"),
    # What a command needs isn't given
    ("eval report", "ct eval report report"),
    ("eval learning-curve --corpus warehouse", "--out curve.png"),
    ("eval learning-curve --corpus warehouse --out curve.jpg", "FILE.png"),
    ("train g3 --corpus warehouse", "--out g3.npz"),
    ("corpus export warehouse --out x", "--to"),
    ("corpus export warehouse --to hugginface --out x", "'huggingface'"),
    ("import slu-core vids", "ct import slu-core slu_core --out"),
    # A file that isn't there or isn't what it should be
    ("train g3 --corpus warehouse --out no/g3.npz", "make it first"),
    ("import slu-core nothere --out x", "give a clone of h2r/slu_core"),
    ("annotate nothere.yaml", "ct annotate init"),
    ("scenarios check nothere.yaml", "there is no 'nothere.yaml'"),
    ("import lerobot lerobot/pusht --out x", "--repo-id"),
    ('follow "Go" --scenario dock_pick_up_tires --model no.npz', "ct train g3 --out"),
    ('follow "Go" --scenario dock_pick_up_tires --video out.avi', "ends in .mp4"),
    # Arguments the wrong way round, or a value of another kind
    (
        "follow dock_pick_up_tires pick it up",
        "ct follow 'pick it up' --scenario dock_pick_up_tires",
    ),
    ("train g3 --out warehouse --corpus g3.npz", "give one of treebank, warehouse"),
    ("eval table1 --corpus warehouse --jobs two", "give a whole number from 1 on"),
    ("eval table1 --corpus warehouse --jobs 0", "give a whole number from 1 on"),
    ("annotate serve --port 99999", "give a whole number from 0 to 65535"),
    ("eval table1 --corpus warehouse --l2 -1", "give a number above 0"),
    ("eval table1 --corpus warehouse --cv sceanrio", "'scenario'"),
    ("eval table1 --corpus warehouse --ablate label", "'labels'"),
    ("render-videos dock_pick_up_tires --out v --size 320", "1280x720"),
    ("render-videos --only 'dok_*' --out v", "'dock_pick_up_tires'"),
    ("render-videos --only nothing --out v", "ct scenarios list"),
]
MISTAKEN_FILES = [
    # The wrong kind of file
    ("eval table1 --corpus noise.mp4", "give the folder of a corpus"),
    ("log show noise.mp4", "give a file that `ct render-videos`"),
    ("log show empty.mcap", "give a file that `ct render-videos`"),
    ("import lerobot films --out t", "name the folder that holds meta, data and videos"),
    ("import rosbag noise.mp4 --out t", "ends in .mcap, .bag, .db3"),
    ("import robomimic noise.mp4 --out t", "name an HDF5 file"),
    ("import treebank latin.csv --out t", "has no trees.jsonl"),
    ("import authored empty.yaml --out t", "docs/authored-corpora.md"),
    ("parse latin.csv", "ct parse --file latin.csv"),
    ('follow "Go" --scenario dock_pick_up_tires --model empty.npz', "ct train g3"),
    # One that is empty, in another encoding, or isn't there
    ("eval subtasks empty.csv", "begin it with answer, video"),
    ("eval subtasks empty.csw", "'empty.csv'"),
    ("log show no.mcap", "ct render-videos"),
    ("eval table3 --test warehouse --plans empty.jsonl", "--write-tasks"),
    ("annotate init new.yaml --videos latin.csv", "save it as UTF-8"),
    ("annotate init new.yaml --videos utf16.csv", "save it as UTF-8"),
    ("annotate init new.yaml --videos empty.csv", "begin it with video"),
    ("annotate init new.yaml --videos texts", "put mp4 or webm files there"),
    ("annotate init new.yaml --videos films", "ffmpeg -i"),
    ("annotate init new.yaml --videos films/pussh.mp4", "'films/push.mp4'"),
    # A study's file that isn't right
    ("annotate check misspelt.yaml", "did you mean 'tasks'?"),
    ("annotate check unclosed.yaml", "expected ',' or ']'"),
    ("annotate check empty.yaml", "docs/annotation.md"),
    ("scenarios check", "my-scenario.yaml"),
    ("annotate restore latin.csv", "give a file of `ct annotate backup`"),
]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with files that new users would name in the wrong place."""
    for kind in ("csv", "yaml", "jsonl", "npz", "mcap"):
        (tmp_path / f"empty.{kind}").touch()
    table = "video,command\npush.mp4,Café\n"
    (tmp_path / "latin.csv").write_bytes(table.encode("latin-1"))
    (tmp_path / "utf16.csv").write_bytes(table.encode("utf-16"))
    (tmp_path / "misspelt.yaml").write_text("name: x\ntitle: x\ntaks: {describe: {answers: 3}}\n")
    (tmp_path / "unclosed.yaml").write_text("name: x\nvideos: [clips\n")
    for name in ("texts", "films"):
        (tmp_path / name).mkdir()
    (tmp_path / "texts/a.txt").touch()
    for name in ("noise.mp4", "films/push.mp4"):
        (tmp_path / name).write_bytes(bytes(range(256)) * 8)
    return tmp_path


@pytest.mark.parametrize(("line", "remedy"), MISTAKES, ids=[line for line, _ in MISTAKES])
def test_a_mistake_is_answered_with_what_to_write(line, remedy, tmp_path, monkeypatch, capsys):
    _answered(line, remedy, tmp_path, monkeypatch, capsys)


@pytest.mark.parametrize(
    ("line", "remedy"), MISTAKEN_FILES, ids=[line for line, _ in MISTAKEN_FILES]
)
def test_a_wrong_file_is_answered_with_the_right_one(line, remedy, folder, monkeypatch, capsys):
    _answered(line, remedy, folder, monkeypatch, capsys)


def _answered(line, remedy, folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    before = sorted(folder.rglob("*"))
    assert run(shlex.split(line)) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert remedy in " ".join(said.err.split())
    assert "Traceback" not in said.err
    assert len(said.err.splitlines()) <= 6
    assert sorted(folder.rglob("*")) == before
    for command in re.findall(r"\bct ((?:[a-z][a-z0-9-]*\b ?)+)", said.err):
        assert _is_command(command.split()), command


def test_a_name_like_no_other_gets_no_suggestions(capsys):
    assert run(["render-videos", "foo", "--out", "videos"]) == 2
    assert "did you mean" not in capsys.readouterr().err


def test_lists_of_commands_and_options_fit_100_columns(capsys):
    for line in ("nothing", "scenarios list --layout dock", "help nothing"):
        assert run(line.split()) == 2
        assert max(map(len, capsys.readouterr().err.splitlines())) <= 100


def _is_command(words: list[str]) -> bool:
    """Check that words begin with a command, with its own one where it is a group."""
    command: click.Command = cli
    for word in words:
        if not isinstance(command, click.Group) or command.invoke_without_command:
            break
        found = command.get_command(click.Context(command, obj={}), word)
        if found is None:
            return command is not cli and word == "has"  # a sentence about a group
        command = found
    return True
