"""Bringing a database's tables up to date."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from pathlib import Path

from sqlalchemy import Engine, MetaData, Table, create_engine, inspect, text

from annotation_app.store.database import reading
from annotation_app.store.models import Base
from g3.errors import FormatError

_VERSIONS = Path(__file__).resolve().parent / "migrations" / "versions"
REVISIONS = frozenset(path.name.partition("_")[0] for path in _VERSIONS.glob("[0-9]*.py"))
"""The migrations that there are."""
NEWEST = max(REVISIONS)
"""The revision that this program's own migrations lead to."""


def migrate(engine: Engine, revision: str = "head", scripts: Sequence[Path] = ()) -> None:
    """Make the tables, or bring older ones up to date, keeping what they hold.

    `scripts` are folders with migrations that come after the program's own. A FormatError says that
    the database is a newer program's.
    """
    if revision != "head" or scripts or not is_current(engine):
        from annotation_app.store.migrating import run_migrations  # noqa: PLC0415 - Alembic is slow

        run_migrations(engine, revision, scripts)


def is_current(engine: Engine) -> bool:
    """Check that the tables are those that this program knows."""
    with reading(engine) as session:
        if not inspect(session.connection()).has_table("alembic_version"):
            return False
        found = session.scalars(text("SELECT version_num FROM alembic_version")).all()
        return list(found) == [NEWEST]


def check_current(engine: Engine) -> None:
    """Check that the tables are those that this program knows; a FormatError if they aren't."""
    if not is_current(engine):
        raise FormatError(
            "the database is not set up, or is an older program's",
            where=engine.url.render_as_string(hide_password=True),
            fix="run `ct annotate`, which brings it up to date",
        )


@functools.cache
def tables_at(revision: str) -> Sequence[Table]:
    """Return the tables after one of `REVISIONS`; referenced tables come first."""
    if revision == NEWEST:
        return Base.metadata.sorted_tables
    from annotation_app.store.migrating import (  # noqa: PLC0415 - Alembic is slow
        changing_tables,
        upgrade,
    )

    found = MetaData()
    engine = create_engine("sqlite://")
    with changing_tables(engine) as connection:
        upgrade(connection, revision)
        found.reflect(connection)
    engine.dispose()
    found.remove(found.tables["alembic_version"])
    return found.sorted_tables
