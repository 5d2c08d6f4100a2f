"""Running the migrations with Alembic: a server whose database is up to date starts without."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from alembic import command
from alembic.config import Config
from alembic.util import CommandError
from sqlalchemy import Connection, Engine

from annotation_app.store.database import BEFORE_FIRST, lock_set_up
from g3.errors import FormatError

SCRIPTS = Path(__file__).resolve().parent / "migrations"


def run_migrations(engine: Engine, revision: str, scripts: Sequence[Path]) -> None:
    """Change the tables; see :func:`annotation_app.store.schema.migrate`."""
    with changing_tables(engine) as connection:
        upgrade(connection, revision, scripts)


def alembic_config(*scripts: Path) -> Config:
    """Return Alembic's configuration."""
    config = Config()
    config.set_main_option("script_location", str(SCRIPTS))
    config.set_main_option("path_separator", "os")
    folders = map(str, (SCRIPTS / "versions", *scripts))
    config.set_main_option("version_locations", os.pathsep.join(folders))
    return config


def upgrade(connection: Connection, revision: str, scripts: Sequence[Path] = ()) -> None:
    """Change the tables, within the connection's transaction."""
    lock_set_up(connection)
    config = alembic_config(*scripts)
    config.attributes["connection"] = connection
    command.upgrade(config, revision)
    _check_references(connection)


@contextmanager
def changing_tables(engine: Engine) -> Iterator[Connection]:
    """Yield a transaction for changes of tables; a FormatError if they aren't this program's."""
    try:
        with engine.connect() as connection:
            _enforce_references(connection, False)
            try:
                with connection.begin():
                    yield connection
            finally:
                _enforce_references(connection, True)
    except CommandError as error:
        raise FormatError(
            f"the database is not one that this program knows: {error}",
            where=engine.url.render_as_string(hide_password=True),
            fix=f"use the program's version that made it, or a newer one; {BEFORE_FIRST}",
        ) from error


def _enforce_references(connection: Connection, on: bool) -> None:
    """Set whether rows that others refer to may be removed, in SQLite.

    A table is changed there by replacing it, which removes the old one.
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
