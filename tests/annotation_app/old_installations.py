"""Installations as version 0.2.0 made them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from sqlalchemy import MetaData, insert, select

from annotation_app.core.config import Config, open_instance
from annotation_app.core.key_file import KEY_FILE, Keys, write_keys
from annotation_app.store.database import opened, reading
from annotation_app.store.migrating import changing_tables, upgrade
from annotation_app.store.models import Base

FIRST_RELEASE = "0008"
"""Revision of the tables of version 0.2.0."""


def old_installation(config: Config, instance: Path, database: str | None = None) -> Config:
    """Make an installation of version 0.2.0 with another one's rows."""
    assert config.salt is not None
    instance.mkdir(parents=True, mode=0o700)
    write_keys(instance / KEY_FILE, Keys(config.secret_key, config.salt))
    made = open_instance(instance, database)
    there = MetaData()
    with (
        opened(config.database) as source,
        reading(source) as session,
        opened(made.database) as engine,
        changing_tables(engine) as connection,
    ):
        upgrade(connection, FIRST_RELEASE)
        there.reflect(connection)
        for table in Base.metadata.sorted_tables:
            old = there.tables.get(table.name)
            if old is not None:
                rows = session.execute(select(table)).mappings()
                kept = [{k: v for k, v in row.items() if k in old.c} for row in rows]
                if kept:
                    connection.execute(insert(old), kept)
    return replace(made, rate_limits=False)
