"""Fifty mistakes of new users: each is answered with what to write, in a few lines."""

from __future__ import annotations

import re
import shlex

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
]


@pytest.mark.parametrize(("line", "remedy"), MISTAKES, ids=[line for line, _ in MISTAKES])
def test_a_mistake_is_answered_with_what_to_write(line, remedy, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(shlex.split(line)) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert remedy in " ".join(said.err.split())
    assert "Traceback" not in said.err
    assert len(said.err.splitlines()) <= 6
    assert list(tmp_path.iterdir()) == []
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
