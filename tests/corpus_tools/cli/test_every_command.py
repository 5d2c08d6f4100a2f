"""What holds for all commands alike: how they write for programs, and what their options mean."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from corpus_tools.cli.console import cli, run
from tests.processes import ct
from tests.tiny_corpus import tiny_corpus

LOGS = Path(__file__).resolve().parents[3] / "datasets/warehouse/logs"
WITHOUT_JSON = {
    "annotate serve": "serves until it is stopped",
    "completion": "its output is a program",
    "demo episodes": "shows people around",
    "help": "shows the help of another command",
}
OTHER_FORMATS = {"annotate export": "--format is that of the files"}


def leaves(name: str, command: click.Command) -> Iterator[tuple[str, click.Command]]:
    if not isinstance(command, click.Group):
        yield name, command
        return
    with click.Context(command) as ctx:
        for sub in command.list_commands(ctx):
            child = command.get_command(ctx, sub)
            assert child is not None
            yield from leaves(f"{name} {sub}".strip(), child)


COMMANDS = dict(leaves("", cli))


def options(command: click.Command) -> dict[str, click.Option]:
    return {
        name: option
        for option in command.params
        if isinstance(option, click.Option)
        for name in option.opts
    }


@pytest.mark.parametrize("name", sorted(COMMANDS.keys() - WITHOUT_JSON))
def test_every_result_can_be_had_as_json(name):
    found = options(COMMANDS[name])
    assert "--json" in found
    if name in OTHER_FORMATS:
        return
    form = found["--format"]
    assert form.default == "text"
    assert isinstance(form.type, click.Choice)
    assert list(form.type.choices)[:2] == ["text", "json"]


def test_exceptions_are_commands():
    assert WITHOUT_JSON.keys() | OTHER_FORMATS <= COMMANDS.keys()


def kind(option: click.Option) -> str:
    """What is to be given: an option's name must not ask for two sorts of things."""
    if option.is_flag:
        return "nothing"
    if isinstance(option.type, click.Path):
        return "path"
    if isinstance(option.type, click.Choice):
        return "text"
    name = option.type.name.removesuffix(" range")
    return "number" if name in ("integer", "float") else name


# Which plans are rated, and the file with judged ones.
TWO_SORTS = {"--plans"}


def test_an_option_means_the_same_everywhere():
    kinds: dict[str, dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
    for command, found in ((c, options(COMMANDS[c])) for c in COMMANDS):
        for name, option in found.items():
            kinds[name][kind(option)].append(command)
    assert {name for name, by in kinds.items() if len(by) > 1} == TWO_SORTS


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("commands")
    tiny_corpus().save(folder / "tiny")
    (folder / "tags.txt").write_text("tree dog\ntree cat\ndog cat\n" * 3)
    return folder


@pytest.mark.parametrize(
    ("line", "key"),
    [
        ("graph 'OBJ(f=it)' --json", "factors"),
        ("corpus show tiny --json", "scenarios"),
        ("corpus stats tiny --json", "commands"),
        ("corpus validate tiny --json", "problems"),
        ("doctor disk --json", "checks"),
        (f"log show {LOGS / 'dock_pick_up_tires.mcap'} --json", "objects"),
        ("scenarios kinds --json", "actions"),
        ("scenarios show dock_pick_up_tires --json", "script"),
        ("scenarios generate --seed 1 --count 1 --out made --json", "scenarios"),
        ("scenarios check made --json", "problems"),
        ("train g3 --corpus tiny --out tiny.npz --json", "feature_sets"),
        ("shards tiny --out shards --json", "examples"),
        ("simulate-workers rate --corpus tiny --out rated --json", "judgments"),
        ("similarity learn tiny --out words.json --json", "names"),
        ("similarity build tags.txt --out tags.npz --json", "images"),
        ("annotate init study.yaml --json", "files"),
        ("eval --power --json", "rows"),
    ],
)
def test_json_is_all_that_is_written(line, key, folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    assert run(shlex.split(line)) == 0
    assert key in json.loads(capsys.readouterr().out)


def test_an_excerpt_holds_what_belongs_to_a_command(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    name = next(iter(tiny_corpus().commands))
    assert run(["corpus", "show", "tiny", name, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [command["id"] for command in found["commands"]] == [name]
    assert {a["command"] for a in found["annotations"]} == {name}
    (context,) = found["contexts"]
    numbers = [thing["trajectory"] for thing in context["objects"]]
    assert all(found["trajectories"][number]["xyz"] for number in numbers)


def test_json_and_another_format_do_not_go_together(capsys):
    assert run(["graph", "OBJ(f = it)", "--json", "--format", "svg"]) == 2
    assert "Give either --json or --format svg." in capsys.readouterr().err
    assert run(["graph", "OBJ(f = it)", "--json", "--format", "json"]) == 0


def test_json_for_an_output_that_has_no_greek():
    done = ct("graph", "OBJ(f = it)", "--json", PYTHONIOENCODING="latin-1")
    assert done.stdout.isascii()
    assert json.loads(done.stdout)["variables"][0]["name"] == "φ_1"


@pytest.mark.parametrize(("settings", "coloured"), [({}, True), ({"NO_COLOR": "1"}, False)])
def test_colour_on_a_terminal_unless_it_is_unwanted(settings, coloured):
    pty = pytest.importorskip("pty")
    ours, theirs = pty.openpty()
    subprocess.run(
        [sys.executable, "-m", "corpus_tools", "doctor", "disk"],
        check=True,
        stdout=theirs,
        env={**{k: v for k, v in os.environ.items() if k != "NO_COLOR"}, **settings},
    )
    shown = os.read(ours, 10_000)
    os.close(ours)
    os.close(theirs)
    assert b"disk" in shown
    assert (b"\x1b[" in shown) is coloured


def test_no_colour_where_there_is_no_terminal(capsys):
    assert run(["doctor", "disk"]) == 0
    assert "\x1b" not in capsys.readouterr().out


def test_table_is_understood_for_text(capsys):
    assert run(["features", "list"]) == run(["features", "list", "--format", "table"]) == 0
    text = capsys.readouterr().out
    assert text[: len(text) // 2] == text[len(text) // 2 :]
