"""What commands about an installation share: options, and names that they had before."""

from __future__ import annotations

import copy
import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import click

from corpus_tools.runtime.terminal import note

DATABASE_VARIABLE = "CT_ANNOTATE_DATABASE"


class Place(NamedTuple):
    """Where an installation is: its folder, and its database if that is no file there."""

    instance: Path
    database: str | None


def INSTALLATION(command: Callable[..., Any]) -> Callable[..., Any]:  # noqa: N802 - as options are
    """Add ``--instance`` and ``--database``; the command gets both as ``place``."""

    @click.option(
        "--instance",
        type=click.Path(path_type=Path, file_okay=False),
        default=Path("annotation"),
        show_default=True,
        help="Folder of the database and the secret key; made if it isn't there.",
    )
    @click.option(
        "--database",
        metavar="URL",
        envvar=DATABASE_VARIABLE,
        help="Database, such as postgresql://user@host/name [default: SQLite in the instance].",
    )
    @functools.wraps(command)
    def with_place(*args: Any, instance: Path, database: str | None, **options: Any) -> Any:
        return command(*args, place=Place(instance, database), **options)

    return with_place


def old_name(command: click.Command, old: str, new: str) -> click.Command:
    """The same command for the name that it had: help doesn't list it, and it names its new name.

    Parameters
    ----------
    old, new
        What follows ``ct``.
    """
    do = command.callback
    assert do is not None  # noqa: S101 - it was made of a function

    @functools.wraps(do)
    def do_with_note(*args: Any, **kwargs: Any) -> Any:
        note(f"note: `ct {old}` is now `ct {new}`; the old name goes with the next version")
        return do(*args, **kwargs)

    alias = copy.copy(command)
    alias.hidden = True
    alias.callback = do_with_note
    return alias
