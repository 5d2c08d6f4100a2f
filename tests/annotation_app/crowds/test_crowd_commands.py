"""`ct crowd`, and the names that its commands had before."""

from __future__ import annotations

import json

import click
import pytest
from flask import Flask

from annotation_app.core.config import Config
from corpus_tools.cli.console import cli, run
from tests.annotation_app.crowds.crowd_worker import Lab
from tests.annotation_app.crowds.stand_ins import MechanicalTurk

OLD = {
    ("publish",): ("crowd", "publish"),
    ("collect",): ("crowd", "collect"),
    ("annotate", "reconcile"): ("crowd", "reconcile"),
}


@pytest.fixture
def options(app: Flask, config: Config, mturk: MechanicalTurk) -> list[str]:
    """What all commands about a study at a platform are given; something was published there."""
    assert Lab(config, mturk.address).publish("--task", "describe", "--people", "2").exit_code == 0
    return ["tests", "--endpoint", mturk.address, "--instance", str(config.instance)]


@pytest.mark.parametrize(
    ("old", "rest"),
    [
        (("publish",), ["--url", "https://lab.example.org", "--task", "describe", "--people", "3"]),
        (("collect",), ["--dry-run"]),
        (("annotate", "reconcile"), []),
    ],
)
@pytest.mark.parametrize("form", ["--json", "--format=text"])
def test_old_names_do_the_same_and_tell_the_new_ones(options, capsys, old, rest, form):
    arguments = ["mturk", *options, *rest, form]
    assert run([*OLD[old], *arguments]) == 0
    new_name = capsys.readouterr()
    assert run([*old, *arguments]) == 0
    old_name = capsys.readouterr()
    is_more = old == ("publish",)  # the first has added a place, so that there is none to add
    assert is_more or old_name.out == new_name.out
    if form == "--json":
        assert json.loads(old_name.out).keys() == json.loads(new_name.out).keys()
    then = f"`ct {' '.join(OLD[old])}`; the old name goes with the next version"
    assert new_name.err == ""
    assert old_name.err == f"note: `ct {' '.join(old)}` is now {then}\n"


@pytest.mark.parametrize("old", OLD)
def test_old_names_fail_as_the_new_ones_do(tmp_path, capsys, old):
    arguments = ["mturk", "tests", "--instance", str(tmp_path)]
    if old == ("publish",):
        arguments += ["--url", "https://lab.example.org"]
    assert run([*OLD[old], *arguments]) == 2
    new_name = capsys.readouterr().err
    assert run([*old, *arguments]) == 2
    assert capsys.readouterr().err.splitlines()[1:] == new_name.splitlines()
    assert run([*old, "--nonsense"]) == 2


def test_help_lists_the_new_names_alone(capsys):
    for old, new in OLD.items():
        assert found(old).params == found(new).params
        for path, is_listed in ((old, False), (new, True)):
            assert run([*path[:-1], "--help"]) == 0
            listed = [line.split()[:1] for line in capsys.readouterr().out.splitlines()]
            assert ([path[-1]] in listed) is is_listed, path


def found(path: tuple[str, ...]) -> click.Command:
    command: click.Command = cli
    for name in path:
        assert isinstance(command, click.Group)
        with click.Context(command) as ctx:
            child = command.get_command(ctx, name)
        assert child is not None
        command = child
    return command
