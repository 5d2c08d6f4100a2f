"""Filling an empty database with a backup: wholly, or leaving nothing behind.

All of the backup is checked before anything is written. Its rows then go into the tables of the
program that wrote it, which the migrations bring up to date, in one transaction. A mark in the
instance's folder shows that a restore is under way. All that a killed one has left is removed by
the next try, and is never served.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import groupby, islice
from pathlib import Path

from sqlalchemy import (
    Connection,
    MetaData,
    Table,
    func,
    insert,
    inspect,
    select,
    text,
)
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import Session

from annotation_app.copies.backups import BATCH, Contents, Reader, check
from annotation_app.core.config import DATABASE_FILE, UNFINISHED
from annotation_app.core.key_file import KEY_FILE, Keys, read_keys, write_keys
from annotation_app.core.sealed_keys import unseal
from annotation_app.privacy import erasure
from annotation_app.store import tombstones
from annotation_app.store.audit import COMMAND_LINE, RESTORED, note
from annotation_app.store.compaction import compact_if_asked
from annotation_app.store.database import lock_set_up, opened
from annotation_app.store.migrating import changing_tables, upgrade
from annotation_app.store.models import Base, Record, Secret
from annotation_app.store.outages import outage_of
from annotation_app.store.salt import keep_check
from annotation_app.store.schema import NEWEST
from annotation_app.store.tombstones import Tombstone
from g3.errors import FormatError
from g3.storage import regular_file
from g3.storage.atomic_file import flush_folder, write_bytes

_BESIDE = ("", "-wal", "-shm", "-journal", "-turn")
"""Suffixes of the files that SQLite and this program keep beside the database."""


@dataclass(frozen=True, slots=True)
class Restored:
    """Result of a restoration, with the number of people whose data were erased again."""

    contents: Contents
    erased: int


def verify(archive: Path) -> Contents:
    """Read a backup; a FormatError if not all of it is there as it was written."""
    with regular_file.opened(archive) as file:
        return check(file, str(archive))


def restore(
    archive: Path,
    instance: Path,
    database: str | None = None,
    *,
    keys: Path | None = None,
    passphrase: str | None = None,
    erased: Collection[Tombstone] = (),
) -> Restored:
    """Fill an empty database with a backup.

    Parameters
    ----------
    keys
        The key file of the installation that the backup is of, if the backup hasn't its keys or
        the passphrase is lost.
    passphrase
        Passphrase that encrypted its keys.
    erased
        People whose data have been erased since.

    Raises
    ------
    FormatError
        If the file isn't a whole backup, the keys aren't those of it, or the database or the
        instance isn't empty.
    """
    with regular_file.opened(archive) as file:
        contents = check(file, str(archive))
        found = _keys(contents, str(archive), keys, passphrase)
        with (
            _vacant(instance, database),
            opened(database or instance / DATABASE_FILE) as engine,
        ):
            write_keys(instance / KEY_FILE, found)
            try:
                with changing_tables(engine) as connection:
                    _fill(connection, Reader(file, str(archive)), contents)
                    again = _finish(connection, found, erased, contents.head.made_at)
            except (SQLAlchemyError, OverflowError, ValueError) as error:
                if outage_of(error) is not None:
                    raise  # it isn't the backup's fault
                reason = str(getattr(error, "orig", None) or error).splitlines()[0]
                raise FormatError(
                    f"the database refuses what the backup holds: {reason[:200]}",
                    where=str(archive),
                    fix="take another backup",
                ) from error
            compact_if_asked(engine)
            tombstones.keep(engine, instance)
    return Restored(contents, again)


def _keys(contents: Contents, where: str, keys: Path | None, passphrase: str | None) -> Keys:
    """Return the key and the salt that belong to a backup."""
    head = contents.head
    if keys is not None:
        found, where = read_keys(keys), str(keys)
    elif head.keys is not None and passphrase is not None:
        found = unseal(head.keys, passphrase, where)
    else:
        raise FormatError(
            "the backup's keys are encrypted" if head.keys else "the backup is without its keys",
            where=where,
            fix=("give --passphrase-file FILE, or " if head.keys else "give ")
            + f"--keys FILE: the file {KEY_FILE} of the installation that it is of",
        )
    if not contents.fits(found):
        raise FormatError(
            "these aren't the keys of the installation that the backup is of",
            where=where,
            fix=f"give the right file {KEY_FILE} with --keys",
        )
    return found


@contextmanager
def _vacant(instance: Path, database: str | None) -> Iterator[None]:
    """Yield a folder that is marked as unfinished meanwhile, and restore it after an error."""
    mark = instance / UNFINISHED
    files = [KEY_FILE] if database is not None else [KEY_FILE, DATABASE_FILE]
    if not mark.exists() and any((instance / name).exists() for name in files):
        raise FormatError(
            "there is an instance already", where=str(instance), fix="name a new folder"
        )
    if database is not None:
        _check_empty(database, mark)
    is_new = not instance.exists()
    try:
        instance.mkdir(parents=True, exist_ok=True, mode=0o700)
        write_bytes(mark, b"", private=True)
    except OSError as error:
        raise FormatError(
            f"the instance can't be made: {error.strerror}", where=str(instance), fix="name another"
        ) from error
    try:
        _clear(instance, files)
        yield
        flush_folder(instance)
    except BaseException:
        _clear(instance, files)
        mark.unlink()
        if is_new:
            with suppress(OSError):  # somebody else has put something into it
                instance.rmdir()
        raise
    mark.unlink()
    flush_folder(instance)


def _clear(instance: Path, files: list[str]) -> None:
    """Remove what a restore that was cut off has written."""
    for name in files:
        for end in _BESIDE:
            (instance / f"{name}{end}").unlink(missing_ok=True)
        for left in instance.glob(f".{name}.new-*"):
            left.unlink()


def _check_empty(database: str, mark: Path) -> None:
    with opened(database) as engine:
        where = engine.url.render_as_string(hide_password=True)
        try:
            with engine.connect() as connection:
                is_empty = _is_empty(connection)
        except SQLAlchemyError as error:
            reason = str(getattr(error, "orig", None) or error).splitlines()[0]
            raise FormatError(
                f"the database can't be opened: {reason}",
                where=where,
                fix="check the address, and that the database exists and can be written to",
            ) from error
    if not is_empty:
        fix = "name another one"
        if mark.exists():
            fix += f"; if an earlier restore has filled it, only delete the file {mark}"
        raise FormatError("the database isn't empty", where=where, fix=fix)


def _is_empty(connection: Connection) -> bool:
    """Check that there are no tables, or only this program's with nothing but its named secrets."""
    tables = set(inspect(connection).get_table_names()) - {"alembic_version"}
    own = Base.metadata.sorted_tables
    if tables - {table.name for table in own}:
        return False
    return not any(
        connection.scalar(select(func.count()).select_from(table))
        for table in own
        if table.name in tables and table.name != Secret.__tablename__
    )


def _fill(connection: Connection, reader: Reader, contents: Contents) -> None:
    """Put a backup's rows into tables of the program that wrote it."""
    lock_set_up(connection)
    if not _is_empty(connection):
        raise FormatError("the database isn't empty any more", fix="name another one")
    if inspect(connection).has_table("alembic_version"):
        Base.metadata.drop_all(connection)  # they are empty
        connection.exec_driver_sql("DROP TABLE alembic_version")
    upgrade(connection, reader.head.schema)
    there = MetaData()
    there.reflect(connection)
    for name, group in groupby(reader.rows(), key=lambda row: row[0]):
        _insert(connection, there.tables[name], (row for _, row in group))
    if reader.sha256 != contents.sha256:
        raise FormatError("the file was changed meanwhile", where=reader.where, fix="try again")


def _insert(connection: Connection, table: Table, rows: Iterator[Record]) -> None:
    while batch := list(islice(rows, BATCH)):
        connection.execute(insert(table), batch)


def _finish(
    connection: Connection, keys: Keys, erased: Collection[Tombstone], made_at: float | None
) -> int:
    """Bring the tables up to date, and erase again whom the backup still had.

    The audit trail shows that the database was restored: its ledger may be behind the platforms'.
    """
    upgrade(connection, NEWEST)
    if connection.dialect.name == "postgresql":
        _set_sequences(connection)
    with Session(connection, expire_on_commit=False) as session:
        keep_check(session, keys.salt)
        again = erasure.erase_again(session, erased)
        note(session, COMMAND_LINE, RESTORED, backup_of=made_at or 0.0)
        session.flush()
    return again


def _set_sequences(connection: Connection) -> None:
    for table in Base.metadata.sorted_tables:
        if "id" in table.c and table.c.id.autoincrement is True:
            connection.execute(
                text(
                    f"SELECT setval(pg_get_serial_sequence('{table.name}', 'id'), "  # noqa: S608
                    f"(SELECT coalesce(max(id), 0) + 1 FROM {table.name}), false)"
                )
            )
