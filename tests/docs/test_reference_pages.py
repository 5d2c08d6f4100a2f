"""The reference has a page for each command and for each listed module."""

from __future__ import annotations

import shutil
from pathlib import Path

import click

from corpus_tools.cli.console import cli
from docs import reference_pages
from tests.docs.blocks import ROOT

PAGE = ROOT / "docs/reference/python.md"


def test_each_command_has_a_page(tmp_path: Path) -> None:
    shutil.copy(PAGE, tmp_path)
    reference_pages.write(tmp_path)
    names = {path.stem for path in (tmp_path / "commands").iterdir()}
    assert names >= {*cli.list_commands(click.Context(cli))}
    follow = (tmp_path / "commands/follow.rst").read_text()
    assert ".. click:: corpus_tools.cli.follow_commands:follow\n   :prog: ct follow\n" in follow


def test_the_contents_lead_to_each_modules_page(tmp_path: Path) -> None:
    shutil.copy(PAGE, tmp_path)
    reference_pages.write(tmp_path)
    text = reference_pages.with_contents(PAGE.read_text())
    assert "{modules}" not in text
    listed = {line for line in text.splitlines() if line.startswith("modules/")}
    assert listed == {f"modules/{path.stem}" for path in (tmp_path / "modules").iterdir()}
    models = (tmp_path / "modules/annotation_app.store.models.rst").read_text()
    assert ":exclude-members: Base" in models
