"""What commands about an installation share."""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import click

from g3.errors import FormatError

DATABASE_VARIABLE = "CT_ANNOTATE_DATABASE"


class Place(NamedTuple):
    """Where an installation is: its folder, and its database if that is no file there."""

    instance: Path
    database: str | None


def no_installation(place: Place) -> FormatError:
    """What to say where an installation is needed and there is none."""
    fix = "name it with --instance, or start one with `ct annotate`"
    return FormatError("there is no installation here", where=str(place.instance), fix=fix)


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
