"""The modes of ``ct eval``: each is a command of its own, chosen by an option."""

import click
import pytest
from click.shell_completion import ShellComplete
from click.testing import CliRunner

from corpus_tools.cli.console import cli
from eval.cli.eval_commands import evaluate
from eval.cli.modes import Modes, OptionSet, takes_one_of

MODES = evaluate.commands
OPTIONS = {name: {o for p in mode.params for o in p.opts} for name, mode in MODES.items()}
EVERY = set().union(*OPTIONS.values()) - MODES.keys()


def ct(*words: str):
    return CliRunner().invoke(cli, ["eval", *words], obj={}, prog_name="ct")


def chosen(name: str) -> list[str]:
    """The arguments that choose a mode."""
    return [*name.split(), *(["folder"] if name in OPTIONS[name] else [])]


def test_help_lists_each_mode_in_a_line():
    lines = ct("--help").stdout.splitlines()
    for name, mode in MODES.items():
        (line,) = [one for one in lines if one.startswith(f"  {name} ") and "ct eval" not in one]
        assert line.endswith(mode.get_short_help_str(80))
        assert len(line) <= 80


@pytest.mark.parametrize("name", MODES)
def test_help_of_a_mode_shows_its_options_and_no_others(name):
    for words in (["--help"], ["--json", "--help"]):
        shown = ct(*chosen(name), *words).stdout
        assert shown.startswith(f"Usage: ct eval {name} [OPTIONS]\n")
        listed = shown.partition("\nOptions:\n")[2].partition("Examples:")[0].splitlines()
        listed = {line.split()[0] for line in listed if line.startswith("  -")}
        assert listed - {"-h,", "--help"} == OPTIONS[name]
    assert ct(*name.split(), "--help").stdout == shown


@pytest.mark.parametrize("name", MODES)
def test_options_of_other_modes_are_refused_with_the_modes_that_have_them(name):
    foreign = EVERY - OPTIONS[name]
    assert foreign
    for option in foreign:
        done = ct(option, "1", *chosen(name))
        assert done.exit_code == 2
        said = " ".join(done.stderr.split())
        assert f"Error: {option} doesn't go with {name}; it is for " in said
        told = said.partition("it is for ")[2]
        assert {n for n in MODES if n in told} == {n for n in MODES if option in OPTIONS[n]}


def test_the_mode_may_stand_anywhere():
    for words in (
        ["--table", "2", "--corpus", "nowhere"],
        ["--corpus", "nowhere", "--table", "2"],
        ["--corpus=nowhere", "--table=2", "--table", "2"],
    ):
        done = ct(*words)
        assert "nowhere" in str(done.exception)
    # What looks like a mode may be the value of an option.
    assert "--sdc" in str(ct("--table", "2", "--corpus", "--sdc").exception)


def completed(*words: str) -> list[str]:
    *before, incomplete = words
    found = ShellComplete(cli, {}, "ct", "_CT_COMPLETE").get_completions(
        ["eval", *before], incomplete
    )
    return [item.value for item in found]


def test_shells_complete_modes_and_then_their_options():
    assert completed("") == completed("--") == list(dict.fromkeys(n.split()[0] for n in MODES))
    assert completed("--le") == ["--learning-curve"]
    assert completed("--table", "") == ["1", "2", "3"]
    assert set(completed("--table", "3", "--")) == OPTIONS["--table 3"] | {"--help"}
    assert completed("--table", "1", "--negatives", "") == ["random", "hard"]
    assert completed("--report", "fo") == ["fo"]


@click.command("--fast")
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
        ("--from 1", "Give --from and --to or --at."),
        ("--from 1 --to 2 --at 3", "Give --from and --to or --at."),
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
