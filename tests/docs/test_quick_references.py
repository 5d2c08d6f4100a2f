"""One page each for `ct` and for Python: all that there is, and nothing else."""

from __future__ import annotations

import re
from collections.abc import Iterator

import click

import ct
from corpus_tools.cli.console import cli
from corpus_tools.corpus.corpus_model import Corpus
from tests.docs.blocks import ROOT

CODE = re.compile(r"`([^`]+)`")


def _commands(group: click.Group, ctx: click.Context, before: str = "ct") -> Iterator[str]:
    for name in group.list_commands(ctx):
        command = group.get_command(ctx, name)
        assert command is not None
        if command.hidden:
            continue
        if isinstance(command, click.Group):
            inner = click.Context(command, parent=ctx, info_name=name)
            yield from _commands(command, inner, f"{before} {name}")
        else:
            yield f"{before} {name}"


def _named(page: str) -> Iterator[str]:
    """Yield the commands of a page; a word alone is a command beside the last one."""
    for row in page.splitlines():
        beside: list[str] = []
        for code in CODE.findall(row if row.startswith("|") else ""):
            words = code.split()
            path = _path(words if words[0] == "ct" else [*beside, *words])
            beside = path[:-1]
            yield " ".join(path)


def _path(words: list[str]) -> list[str]:
    """Return the words that name a command, without its arguments."""
    command: click.Command = cli
    path = ["ct"]
    for word in words[1:]:
        if not isinstance(command, click.Group) or not word.islower():
            break
        found = command.get_command(click.Context(command, obj={}), word)
        assert found is not None, " ".join(words)
        command, path = found, [*path, word]
    return path


def test_every_command_is_on_its_page() -> None:
    page = (ROOT / "docs/reference/quick-ct.md").read_text()
    missing = set(_commands(cli, click.Context(cli, obj={}))) - set(_named(page))
    assert missing == {"ct help"}  # above the tables


def test_every_function_is_on_its_page() -> None:
    page = (ROOT / "docs/python.md").read_text()
    named = set(re.findall(r"\bct\.(\w+)", page)) | set(re.findall(r"`(import_\w+)", page))
    assert {name for name in ct.__all__ if not name.startswith("_")} == named
    for method in re.findall(r"\bcorpus\.(\w+)", page):
        assert hasattr(Corpus, method), method
