"""Options that name a corpus."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click
from click.shell_completion import CompletionItem

Command = Callable[..., Any]


class _CorpusName(click.ParamType[str]):
    """The name of a bundled corpus, or a corpus's folder."""

    name = "text"

    def get_missing_message(self, param: click.Parameter, ctx: click.Context | None) -> str:
        return f"Give a corpus's folder or name, such as {param.opts[0]} warehouse."

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        from corpus_tools.runtime.shipped import bundled  # noqa: PLC0415 - `ct --help` does without

        named = [CompletionItem(n) for n in bundled() if n.startswith(incomplete)]
        return [*named, CompletionItem(incomplete, type="dir")]


def corpus_option(
    *names: str, metavar: str = "CORPUS", **about: Any
) -> Callable[[Command], Command]:
    """Make an option that names a corpus."""
    return click.option(*names, metavar=metavar, type=_CorpusName(), **about)
