"""Backups: a file that holds every row of a database, whichever kind of database it is."""

from __future__ import annotations

import base64
import gzip
import io
from collections.abc import Iterator
from itertools import groupby, islice
from pathlib import Path
from typing import Any

import msgspec
from sqlalchemy import LargeBinary, Table, delete, func, insert, select, text
from sqlalchemy.orm import Session

from annotation_app.config import DATABASE_FILE, KEY_FILE, Config, open_instance
from annotation_app.database import opened, reading, transaction
from annotation_app.models import Base, Secret
from annotation_app.schema import is_current, migrate
from g3.atomic_file import write_bytes
from g3.errors import FormatError

VERSION = 1
_BATCH = 1000


def back_up(config: Config, archive: Path) -> int:
    """Write all rows, and the secret key, to a file that only its owner may read.

    It holds one moment of the database, which may be served meanwhile.

    Returns
    -------
    int
        How many rows it holds.

    Raises
    ------
    FormatError
        If there is no database of this program's.
    """
    rows = 0
    content = io.BytesIO()
    encoder = msgspec.json.Encoder()
    with (
        opened(config.database) as engine,
        gzip.GzipFile(fileobj=content, mode="wb", mtime=0) as file,
    ):
        if not is_current(engine):
            raise FormatError(
                "there is no study to back up", where=str(config.instance), fix="name its instance"
            )
        head = {"version": VERSION, "key": config.secret_key.decode()}
        file.write(encoder.encode(head) + b"\n")
        with reading(engine, one_state=True) as session:
            for table in Base.metadata.sorted_tables:
                for row in session.execute(select(table)).mappings():
                    file.write(encoder.encode([str(table.name), _plain(row)]) + b"\n")
                    rows += 1
    write_bytes(archive, content.getvalue())
    archive.chmod(0o600)
    return rows


def restore(archive: Path, instance: Path, database: str | None = None) -> int:
    """Fill an empty database with a backup.

    Returns
    -------
    int
        How many rows it holds.

    Raises
    ------
    FormatError
        If the file is no backup, or the database or the instance isn't empty.
    """
    if (instance / KEY_FILE).exists() or (database is None and (instance / DATABASE_FILE).exists()):
        raise FormatError(
            "there is an instance already", where=str(instance), fix="name a new folder"
        )
    lines = _lines(archive)
    head = next(lines)
    if not isinstance(head, dict) or head.get("version") != VERSION:
        raise FormatError("this is no backup that can be read", where=str(archive))
    config = open_instance(instance, database)
    (instance / KEY_FILE).write_bytes(str(head["key"]).encode())
    with opened(config.database) as engine:
        migrate(engine)
        with transaction(engine) as session:
            _check_empty(session, config)
            session.execute(delete(Secret))
            rows = _insert(session, lines)
            if engine.dialect.name == "postgresql":
                _set_sequences(session)
    return rows


def _insert(session: Session, lines: Iterator[Any]) -> int:
    tables = {table.name: table for table in Base.metadata.sorted_tables}
    count = 0
    for name, group in groupby(lines, key=lambda line: str(line[0])):
        rows = (_stored(tables[name], row) for _, row in group)
        while batch := list(islice(rows, _BATCH)):
            session.execute(insert(tables[name]), batch)
            count += len(batch)
    return count


def _lines(archive: Path) -> Iterator[Any]:
    try:
        with gzip.open(archive, "rb") as file:
            for line in file:
                yield msgspec.json.decode(line)
    except (OSError, EOFError, msgspec.DecodeError) as error:
        raise FormatError(
            f"the backup can't be read: {error}", where=str(archive), fix="take another one"
        ) from error


def _plain(row: Any) -> dict[str, Any]:
    return {
        str(name): base64.b64encode(value).decode() if isinstance(value, bytes) else value
        for name, value in row.items()
    }


def _stored(table: Table, row: dict[str, Any]) -> dict[str, Any]:
    return {
        name: base64.b64decode(value) if isinstance(table.c[name].type, LargeBinary) else value
        for name, value in row.items()
    }


def _check_empty(session: Session, config: Config) -> None:
    for table in Base.metadata.sorted_tables:
        count = session.scalar(select(func.count()).select_from(table))
        if count and table.name != Secret.__tablename__:
            raise FormatError(
                "the database isn't empty", where=str(config.instance), fix="name another one"
            )


def _set_sequences(session: Session) -> None:
    for table in Base.metadata.sorted_tables:
        if "id" in table.c and table.c.id.autoincrement is True:
            session.execute(
                text(
                    f"SELECT setval(pg_get_serial_sequence('{table.name}', 'id'), "  # noqa: S608
                    f"(SELECT coalesce(max(id), 0) + 1 FROM {table.name}), false)"
                )
            )
