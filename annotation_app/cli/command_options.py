"""Options that commands about an installation share."""

from __future__ import annotations

from pathlib import Path

import click

DATABASE_VARIABLE = "CT_ANNOTATE_DATABASE"

INSTANCE = click.option(
    "--instance",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("annotation"),
    show_default=True,
    help="Folder of the database and the secret key; made if it isn't there.",
)
DATABASE = click.option(
    "--database",
    metavar="URL",
    envvar=DATABASE_VARIABLE,
    help="Database, such as postgresql://user@host/name [default: SQLite in the instance].",
)
