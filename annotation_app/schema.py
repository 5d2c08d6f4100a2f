"""Bringing a database's tables up to date, and the salt that is made with them."""

from __future__ import annotations

import secrets
from collections.abc import Sequence
from pathlib import Path

from sqlalchemy import Engine, inspect, text
from sqlalchemy.exc import OperationalError

from annotation_app.database import lock_set_up, reading, transaction
from annotation_app.models import Secret
from annotation_app.people import SALT
from g3.errors import FormatError

SALT_BYTES = 32
_VERSIONS = Path(__file__).resolve().parent / "migrations" / "versions"
NEWEST = max(path.name.partition("_")[0] for path in _VERSIONS.glob("[0-9]*.py"))
"""The revision that this program's own migrations lead to."""


def migrate(engine: Engine, revision: str = "head", scripts: Sequence[Path] = ()) -> None:
    """Make the tables, or bring older ones up to date, keeping what they hold.

    Parameters
    ----------
    scripts
        Folders with migrations that come after the program's own.

    Raises
    ------
    FormatError
        If the database can't be reached, or a newer program has made it.
    """
    where = engine.url.render_as_string(hide_password=True)
    try:
        if revision != "head" or scripts or not is_current(engine):
            from annotation_app.migrating import run_migrations  # noqa: PLC0415 - Alembic is slow

            run_migrations(engine, revision, scripts)
    except OperationalError as error:
        reason = str(error.orig).splitlines()[0]
        raise FormatError(
            f"the database can't be opened: {reason}",
            where=where,
            fix="check the address, and that the database exists and can be written to",
        ) from error
    _make_salt(engine)


def is_current(engine: Engine) -> bool:
    """Whether the tables are those that this program knows."""
    with reading(engine) as session:
        if not inspect(session.connection()).has_table("alembic_version"):
            return False
        found = session.scalars(text("SELECT version_num FROM alembic_version")).all()
        return list(found) == [NEWEST]


def installation_salt(engine: Engine) -> bytes:
    """What people's ids are hashed with.

    Raises
    ------
    FormatError
        If the database hasn't been set up.
    """
    if not is_current(engine):
        raise FormatError(
            "the database is not set up, or is an older program's",
            where=engine.url.render_as_string(hide_password=True),
            fix="run `ct annotate`, which brings it up to date",
        )
    with transaction(engine) as session:
        return session.get_one(Secret, SALT).value


def _make_salt(engine: Engine) -> None:
    with transaction(engine) as session:
        lock_set_up(session.connection())
        if session.get(Secret, SALT) is None:
            session.add(Secret(name=SALT, value=secrets.token_bytes(SALT_BYTES)))
