"""The commands of ``ct eval``, which options choose too, as in ``ct eval --table 1``."""

import click
import pytest
from click.shell_completion import ShellComplete
from click.testing import CliRunner

from corpus_tools.cli.console import cli
from eval.cli.eval_commands import evaluate
from eval.cli.modes import Modes, OptionSet, takes_one_of

COMMANDS = evaluate.commands
OPTIONS = {
    name: {o for p in command.params if isinstance(p, click.Option) for o in p.opts}
    for name, command in COMMANDS.items()
}
MODES = {
    "table1": "--table 1",
    "table2": "--table 2",
    "table3": "--table 3",
    "learning-curve": "--learning-curve",
    "errors": "--errors",
    "sdc": "--sdc",
    "end-to-end": "--end-to-end",
    "judge-validity": "--judge-validity",
    "report": "--report",
    "power": "--power",
    "subtasks": "--subtasks",
}


def ct(*words: str):
    return CliRunner().invoke(cli, ["eval", *words], obj={}, prog_name="ct")


def test_each_command_has_an_option():
    assert list(MODES) == list(COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_help_of_a_command_shows_its_options_and_no_others(name):
    shown = ct(name, "--help").stdout
    assert shown.startswith(f"Usage: ct eval {name} [OPTIONS]")
    listed = shown.partition("\nOptions:\n")[2].partition("Examples:")[0].splitlines()
    listed = {line.split()[0] for line in listed if line.startswith("  -")}
    assert listed - {"-h,", "--help"} == OPTIONS[name]
    for words in ([*MODES[name].split(), "--help"], ["--json", "--help", *MODES[name].split()]):
        assert ct(*words).stdout == shown


@pytest.mark.parametrize(
    "words",
    [
        ["table2", "--corpus", "nowhere"],
        ["--table", "2", "--corpus", "nowhere"],
        ["--corpus", "nowhere", "--table=2"],
        ["--report", "report", "--corpus", "nowhere"],
        ["--corpus", "nowhere", "--report=report"],
    ],
)
def test_the_option_of_a_command_may_stand_anywhere(words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert "corpus 'nowhere'" in str(ct(*words).exception)


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (["tabel1"], "'table1'"),
        (["--table", "4"], "No such command 'table4'"),
        (["--table"], "'table1'"),
        (["table1", "--sdc"], "Give one of table1 and sdc"),
        (["table1", "--corpsu", "x"], "'--corpus'"),
        (["table3"], "such as --test warehouse"),
        (["report"], "Missing argument 'FOLDER'"),
    ],
)
def test_mistakes_are_answered_with_the_remedy(words, meant):
    done = ct(*words)
    assert done.exit_code == 2
    assert meant in " ".join(done.stderr.split())


def completed(*words: str) -> list[str]:
    *before, incomplete = words
    found = ShellComplete(cli, {}, "ct", "_CT_COMPLETE").get_completions(
        ["eval", *before], incomplete
    )
    return [item.value for item in found]


def test_shells_complete_commands_and_then_their_options():
    assert completed("") == list(COMMANDS)
    assert completed("le") == ["learning-curve"]
    for chosen in (["table3"], ["--table", "3"]):
        assert set(completed(*chosen, "--")) == OPTIONS["table3"] | {"--help"}
    assert completed("--table", "1", "--negatives", "") == ["random", "hard"]
    assert completed("report", "fo") == ["fo"]
    assert "warehouse" in completed("table2", "--corpus", "ware")


@click.command("fast")
@takes_one_of(OptionSet(), OptionSet(("--from", "--to"), ("--by",)), OptionSet(("--at",)))
@click.option("--from", "since")
@click.option("--to")
@click.option("--by")
@click.option("--at")
@click.option("--free")
def fast(**given):
    """Go fast."""


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("", None),
        ("--free 1", None),
        ("--from 1 --to 2 --free 1", None),
        ("--from 1 --to 2 --by 1", None),
        ("--at 1 --free 2", None),
        ("--from 1", "Give --from and --to."),
        ("--from 1 --to 2 --at 3", "Give --from and --to; or --at."),
        ("--by 1", "--by goes with --from and --to."),
        ("--at 1 --by 1", "--by doesn't go with --at."),
    ],
)
def test_options_that_belong_together(line, message):
    modes = Modes("go", commands=[fast])
    done = CliRunner().invoke(modes, ["--fast", *line.split()])
    assert done.exit_code == (2 if message else 0)
    if message:
        assert message in done.stderr
