"""Installations and backups as the first program made them: the salt is in the database."""

from __future__ import annotations

import base64
import gzip
import json
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

from sqlalchemy import Engine, MetaData, insert, select

from annotation_app.core.config import DATABASE_FILE, Config, open_instance
from annotation_app.core.key_file import Keys, write_keys
from annotation_app.store.database import opened, reading
from annotation_app.store.migrating import changing_tables, upgrade
from annotation_app.store.models import Base
from annotation_app.store.schema import tables_at

SALT = bytes(range(100, 132))
KEY = "5a" * 32

Row = tuple[str, dict[str, Any]]


USUAL: dict[str, dict[str, Any]] = {
    "study": {"id": "s", "name": "s", "config": {}, "created_at": 0.0},
    "person": {
        "id": "p", "role": "worker", "provider": "mturk", "external_hash": "h", "profile": {},
        "created_at": 0.0,
    },
    "item": {"study_id": "s", "task": "describe", "payload": {}, "rank": 0.0},
    "slot": {},
    "event": {"person_id": "p", "name": "submit", "body": {}, "at": 0.0},
    "answer": {"person_id": "p", "task": "describe", "body": {}, "surplus": False, "at": 0.0},
    "participation": {
        "study_id": "s", "person_id": "p", "provider": "mturk", "task": "describe", "items": 2,
        "begun_at": 100.0,
    },
}  # fmt: skip
"""Rows of an older database, but for what tells them apart."""


def put_rows(engine: Engine, *rows: Row) -> None:
    """Put rows into a database of an older program."""
    there = MetaData()
    with engine.begin() as connection:
        there.reflect(connection)
        for table, row in rows:
            connection.execute(insert(there.tables[table]), USUAL[table] | row)


def old_rows(config: Config) -> Iterator[Row]:
    """A database's rows as the first program had them, with a draft beside each answer."""
    old = {table.name: set(table.c.keys()) for table in tables_at("0001")}
    with opened(config.database) as engine, reading(engine) as session:
        for table in Base.metadata.sorted_tables:
            if table.name not in old or table.name == "secret":
                continue
            for row in session.execute(select(table)).mappings():
                yield str(table.name), {k: v for k, v in row.items() if k in old[table.name]}
        for answer in session.execute(select(Base.metadata.tables["answer"])).mappings():
            keys = {name: answer[name] for name in ("item_id", "person_id", "at")}
            yield "draft", {**keys, "revision": 3, "body": {"text": "taken back"}}
    yield "secret", {"name": "salt", "value": SALT}


def old_installation(config: Config, instance: Path, database: str | None = None) -> Config:
    """An installation of the first program with another one's rows."""
    write_old_keys(instance)
    made = open_instance(instance, database)
    with opened(made.database) as engine, changing_tables(engine) as connection:
        upgrade(connection, "0001")
        there = MetaData()
        there.reflect(connection)
        for table, row in old_rows(config):
            connection.execute(insert(there.tables[table]), row)
    if database is None:
        leave_a_trace(made.instance / DATABASE_FILE)
    return replace(made, rate_limits=False)


def leave_a_trace(file: Path) -> None:
    """Have the salt in a free place of the file too, as SQLite leaves what it has moved."""
    with closing(sqlite3.connect(file, isolation_level=None)) as connection:
        connection.execute("PRAGMA secure_delete=OFF")
        connection.execute("INSERT INTO secret VALUES ('zzz', ?)", (SALT,))
        connection.execute("DELETE FROM secret WHERE name = 'zzz'")
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")


def old_archive(config: Config, archive: Path) -> int:
    """A backup as the first program wrote it; how many rows it has."""
    lines: list[Any] = [{"version": 1, "key": KEY}]
    lines += [[table, plain(row)] for table, row in old_rows(config)]
    write_lines(archive, lines)
    return len(lines) - 1


def write_lines(archive: Path, lines: list[Any]) -> None:
    content = "".join(f"{json.dumps(line)}\n" for line in lines)
    archive.write_bytes(gzip.compress(content.encode(), mtime=0))


def plain(row: dict[str, Any]) -> dict[str, Any]:
    return {k: base64.b64encode(v).decode() if isinstance(v, bytes) else v for k, v in row.items()}


def write_old_keys(instance: Path) -> None:
    instance.mkdir(parents=True, mode=0o700)
    write_keys(instance / "secret-key", Keys(KEY.encode(), None))
