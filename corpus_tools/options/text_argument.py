"""The argument by which a command takes a text."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from typing import Any

import click

Command = Callable[..., Any]


def text_argument(name: str) -> Callable[[Command], Command]:
    """Add an argument for one text, which may be left out.

    A text of several arguments wasn't quoted; the error shows it quoted.
    """
    shown = f"[{name.upper()}]"
    return click.argument(name, metavar=shown, nargs=-1, callback=_in_one)


def _in_one(ctx: click.Context, _: click.Parameter, words: tuple[str, ...]) -> str | None:
    if len(words) > 1:
        quoted = shlex.quote(" ".join(words))
        raise click.UsageError(f"Put the text in quotes: {ctx.command_path} {quoted}", ctx)
    return words[0] if words else None
