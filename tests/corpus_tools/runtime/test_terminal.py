"""Nothing that a file or a person wrote controls the terminal that it is printed on."""

from __future__ import annotations

import json
import re
import unicodedata
from dataclasses import replace
from pathlib import Path

import click
import pytest
from hypothesis import given
from hypothesis import strategies as st

from corpus_tools.cli.console import run
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.runtime.terminal import visible
from g3.annotation import Command
from tests.tiny_corpus import tiny_corpus

EVIL = "\x1b[2J\x00\x9b1m\u202egnp.exe\x7f\r\x08"
PACKAGES = [Path(__file__).parents[3] / name for name in ("corpus_tools", "eval", "annotation_app")]


def controls(text: str) -> set[str]:
    """The characters of a text that control something, but for the end of a line and tabs."""
    return {
        c
        for c in text
        if (unicodedata.category(c) == "Cc" and c not in "\n\t")
        or unicodedata.bidirectional(c) in {"LRE", "RLE", "PDF", "LRO", "RLO", "LRI", "RLI", "PDI"}
    }


@given(st.text())
def test_a_visible_text_controls_nothing_and_json_stays_what_it_is(text):
    assert not controls(visible(text))
    assert visible(visible(text)) == visible(text)
    assert json.loads(visible(json.dumps(text, ensure_ascii=False))) == text


def test_only_colours_are_let_through_where_we_colour():
    styled = click.style("ok", fg="green", bold=True)
    assert visible(styled, styled=True) == styled
    for evil in ("\x1b[2J", "\x1b[8mhidden", "\x1b]0;title\x07", "\x9b1m", "\x1b[10A"):
        assert not controls(visible(evil, styled=True))


@pytest.fixture
def evil_corpus(tmp_path):
    tiny = tiny_corpus()
    commands = {**tiny.commands, EVIL: Command(EVIL, f"Go {EVIL}", EVIL, "v")}
    made = Corpus.build(
        f"evil{EVIL}",
        contexts=[replace(c, id=f"{name}{EVIL}") for name, c in tiny.contexts.items()],
        commands=commands.values(),
        annotations=(),
        source=EVIL,
        licence=EVIL,
    )
    path = tmp_path / "evil\x1b[2J"
    made.save(path)
    return path


@pytest.mark.parametrize(
    "arguments",
    [
        ["corpus", "show", "PATH"],
        ["corpus", "show", "PATH", EVIL],
        ["corpus", "show", "PATH", EVIL, "--json"],
        ["corpus", "show", "PATH", f"no such {EVIL}"],
        ["corpus", "stats", "PATH"],
        ["corpus", "validate", "PATH"],
        ["corpus", "seal", "PATH"],
        ["corpus", EVIL],
        ["corpus", "stats", f"PATH{EVIL}"],
        ["follow", EVIL, "--context", f"PATH:{EVIL}"],
        ["follow", "go", "--scenario", EVIL],
        ["parse", f"Lift the {EVIL} pallet", "--n-best", "2"],
        ["parse", "go", "--model", f"PATH{EVIL}"],
        ["graph", f"OBJ(f = {EVIL})"],
        ["graph", f"OBJ(f = the {EVIL} (pallet)"],
        [f"--{EVIL}"],
        ["--verbose", "corpus", "show", "PATH", f"no such {EVIL}"],
        ["train", "g3", "--corpus", "PATH", "--out", f"PATH/m{EVIL}"],
        ["eval", "--table", "1", "--corpus", f"PATH{EVIL}", "--cv", "scenario"],
        ["import", "authored", f"PATH{EVIL}", "--out", f"PATH{EVIL}"],
    ],
)
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_commands_print_nothing_that_controls(evil_corpus, arguments, capfd):
    arguments = [part.replace("PATH", str(evil_corpus)).replace("\0", "") for part in arguments]
    if EVIL.replace("\0", "") in arguments and arguments[1] == "show":  # which no shell could give
        arguments = [EVIL if part == EVIL.replace("\0", "") else part for part in arguments]
    status = run(arguments)
    out, err = capfd.readouterr()
    assert out + err
    assert status in (0, 2), err
    assert not controls(out), out
    assert not controls(err), err


def test_a_damaged_corpus_is_told_visibly(evil_corpus, capfd):
    """A NUL that stands where a name should be: the echo of what is wrong shows it."""
    path = evil_corpus / "commands.jsonl"
    path.write_text(path.read_text().replace('"id":"', '"id\\u0000\\u001b[2J":"', 1))
    for command in ("validate", "stats"):
        assert run(["corpus", command, str(evil_corpus)]) == 2
        out, err = capfd.readouterr()
        assert "\\u0000" in out + err
        assert not controls(out + err)


@pytest.mark.parametrize(
    "arguments", [["graph", "x" * 50_000], ["corpus", "stats", "x" * 50_000], ["x" * 50_000]]
)
def test_an_error_repeats_nothing_endless(arguments, capfd):
    assert run(arguments) == 2
    err = capfd.readouterr().err
    assert len(err) < 3000
    assert " characters] x" in err


def test_everything_is_printed_by_the_terminal_module():
    """Others would print what they are given; the script for completion is a program."""
    other = re.compile(r"\bclick\.(echo|secho|echo_via_pager)\(|^\s*print\(", re.MULTILINE)
    found = {
        f"{path.relative_to(package.parent).as_posix()}: {match.group().strip()}"
        for package in PACKAGES
        for path in package.rglob("*.py")
        for match in other.finditer(path.read_text(encoding="utf-8"))
        if path.name != "terminal.py"
    }
    assert found == {"corpus_tools/cli/doctor_commands.py: click.echo("}
