"""Bringing a database's tables up to date, and the salt that is made with them."""

from __future__ import annotations

import os
import secrets
from collections.abc import Sequence
from pathlib import Path

from alembic import command
from alembic.config import Config as AlembicConfig
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from alembic.util import CommandError
from sqlalchemy import Connection, Engine
from sqlalchemy.exc import OperationalError

from annotation_app.database import lock_set_up, transaction
from annotation_app.models import Secret
from annotation_app.people import SALT
from g3.errors import FormatError

SALT_BYTES = 32
_SCRIPTS = Path(__file__).resolve().parent / "migrations"


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
        with engine.connect() as connection:
            _enforce_references(connection, False)
            try:
                _upgrade(connection, revision, scripts)
            finally:
                _enforce_references(connection, True)
    except OperationalError as error:
        reason = str(error.orig).splitlines()[0]
        raise FormatError(
            f"the database can't be opened: {reason}",
            where=where,
            fix="check the address, and that the database exists and can be written to",
        ) from error
    except CommandError as error:
        raise FormatError(
            f"the database is not one that this program knows: {error}",
            where=where,
            fix="use the program's version that made it, or a newer one",
        ) from error
    _make_salt(engine)


def alembic_config(*scripts: Path) -> AlembicConfig:
    """What Alembic needs to know."""
    config = AlembicConfig()
    config.set_main_option("script_location", str(_SCRIPTS))
    config.set_main_option("path_separator", "os")
    folders = map(str, (_SCRIPTS / "versions", *scripts))
    config.set_main_option("version_locations", os.pathsep.join(folders))
    return config


def _upgrade(connection: Connection, revision: str, scripts: Sequence[Path]) -> None:
    with connection.begin():
        lock_set_up(connection)
        config = alembic_config(*scripts)
        config.attributes["connection"] = connection
        command.upgrade(config, revision)
        _check_references(connection)


def _enforce_references(connection: Connection, on: bool) -> None:
    """In SQLite, whether rows that others refer to may be removed.

    A table is changed there by making it anew, which removes the old one.
    """
    if connection.dialect.name == "sqlite":
        raw = connection.connection.dbapi_connection
        assert raw is not None  # noqa: S101 - it is open
        raw.execute(f"PRAGMA foreign_keys={'ON' if on else 'OFF'}")


def _check_references(connection: Connection) -> None:
    if connection.dialect.name == "sqlite":
        broken = connection.exec_driver_sql("PRAGMA foreign_key_check").first()
        if broken is not None:
            raise CommandError(f"rows of {broken[0]} would refer to nothing")


def is_current(engine: Engine) -> bool:
    """Whether the tables are those that this program knows."""
    head = ScriptDirectory.from_config(alembic_config()).get_current_head()
    with engine.connect() as connection:
        return MigrationContext.configure(connection).get_current_revision() == head


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
