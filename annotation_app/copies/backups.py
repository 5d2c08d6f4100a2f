"""Backups: files that hold every row of a database of any kind; writing and checking them.

It is gzipped text of one JSON value a line: a head, ``[table, row]`` for each row, and an end.
Rows refer to rows of earlier tables only. The end has the number of rows of each table and the
SHA-256 of all lines before.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import time
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, TypeAlias

import msgspec
from sqlalchemy import JSON, Column, LargeBinary, Table, select
from sqlalchemy.orm import Session

from annotation_app.core.config import Config
from annotation_app.core.key_file import Keys, check_value
from annotation_app.core.sealed_keys import seal
from annotation_app.store.compaction import DUE
from annotation_app.store.database import BEFORE_FIRST, opened, reading
from annotation_app.store.models import Base, Record
from annotation_app.store.salt import CHECK, installation_salt
from annotation_app.store.schema import NEWEST, REVISIONS, is_current, tables_at
from g3.errors import FormatError
from g3.storage.atomic_file import replacing

VERSION = 2
GZIP_HEAD = bytes.fromhex("1f8b08 00 00000000 00 ff")
"""First bytes of this program's files, with neither a name nor a time."""
LEVEL = 6
"""Compression level; another one changes `GZIP_HEAD`."""
_OF_GZIP = 3
"""Operating system that gzip on Unix writes, where this program writes 255."""
BATCH = 1000
LONGEST_LINE = 1 << 27
"""Largest number of bytes of a line in memory; no row has as many."""
TAKE_ANOTHER = "take another backup"

Row: TypeAlias = tuple[str, Record]


class Head(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """The first line."""

    version: int
    """Version of the file's form."""
    schema: str
    """Revision of the tables that the rows belong to."""
    made_at: float | None = None
    """Seconds since 1970."""
    keys: dict[str, str] | None = None
    """The encrypted keys; none if they were left out."""


class End(msgspec.Struct, frozen=True):
    """The last line."""

    counts: dict[str, int]
    sha256: str


@dataclass(frozen=True, slots=True)
class Contents:
    """Facts about a backup that was read to its end."""

    head: Head
    counts: Mapping[str, int]
    """Rows by table."""
    sha256: str
    """Digest of all lines but the last."""
    check: bytes | None
    """Check value of the salt."""

    @property
    def rows(self) -> int:
        """Number of rows."""
        return sum(self.counts.values())

    def fits(self, keys: Keys) -> bool:
        """Check that keys belong to the backup's installation, as far as the backup shows it."""
        return self.check is None or check_value(keys.salt) == self.check


def back_up(config: Config, archive: Path, passphrase: str | None) -> int:
    """Write all rows to a file that only its owner may read, from the moment it is made; how many.

    It holds one moment of the database, which may be served meanwhile. The key and the salt are
    encrypted with the passphrase; if there is none they are left out. A FormatError says that there
    is no database of this program's, or that the passphrase is too short.
    """
    counts = {str(table.name): 0 for table in Base.metadata.sorted_tables}
    digest = hashlib.sha256()
    with opened(config.database) as engine:
        if not is_current(engine):
            raise FormatError(
                "there is no study to back up", where=str(config.instance), fix="name its instance"
            )
        sealed = None
        if passphrase is not None:
            salt = installation_salt(engine, config)
            sealed = seal(Keys(config.secret_key, salt), passphrase)
        head = Head(version=VERSION, schema=NEWEST, made_at=time.time(), keys=sealed)
        with (
            replacing(archive, private=True) as file,
            gzip.GzipFile("", "wb", LEVEL, file, mtime=0) as lines,
            reading(engine, one_state=True) as session,
        ):
            line = msgspec.json.encode(head) + b"\n"
            digest.update(line)
            lines.write(line)
            for table, row in _rows(session):
                line = encoded_row(table, row)
                digest.update(line)
                lines.write(line)
                counts[table] += 1
            lines.write(encoded_end(counts, digest.hexdigest()))
    return sum(counts.values())


def check(file: BinaryIO, where: str) -> Contents:
    """Read all of a backup; a FormatError if it isn't complete and as it was written."""
    counts: Counter[str] = Counter()
    secrets: dict[str, bytes] = {}
    reader = Reader(file, where)
    for table, row in reader.rows():
        counts[table] += 1
        if table == "secret":
            secrets[row["name"]] = row["value"]
    return Contents(reader.head, counts, reader.sha256, secrets.get(CHECK))


class Reader:
    """A reader of a backup, once. The head is there at once, the digest after the last row."""

    def __init__(self, file: BinaryIO, where: str) -> None:
        self.where = where
        self.line = 0
        self.sha256 = ""
        self._digest = hashlib.sha256()
        file.seek(0)
        start = file.read(10)
        if not start:
            raise self._error("the file is empty")
        file.seek(0)
        self._lines = self._read(file)
        self.head = self._head(next(self._lines, b""), start)

    def rows(self) -> Iterator[Row]:
        """Yield each row as the database has it, checked against its table.

        A FormatError reports a fault, at the latest after the last row.
        """
        tables = {str(table.name): table for table in tables_at(self.head.schema)}
        counts = dict.fromkeys(tables, 0)
        for line in self._lines:
            if line.startswith(b"{"):
                self._end(line, counts)
                return
            self._digest.update(line)
            table, row = self._row(line, tables)
            counts[table] += 1
            yield table, row
        raise self._error("the backup has no end: it was cut off")

    def _head(self, line: bytes, start: bytes) -> Head:
        self._digest.update(line)
        try:
            head = msgspec.json.decode(line, type=Head)
        except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
            raise self._error("this is no backup of `ct annotate backup`") from error
        if head.version != VERSION or head.schema not in REVISIONS:
            raise self._error(
                "the backup is of a program that this one doesn't know",
                fix=f"use the version of the program that made it, or a newer one; {BEFORE_FIRST}",
            )
        # What the digest doesn't cover; who has compressed the lines anew is welcome.
        if start != GZIP_HEAD and start[9] != _OF_GZIP:
            raise self._error("the head of the gzip file was changed")
        return head

    def _end(self, line: bytes, counts: dict[str, int]) -> None:
        try:
            end = msgspec.json.decode(line, type=End)
        except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
            raise self._error(f"the backup's end can't be read: {error}") from error
        for table in sorted({*counts, *end.counts}):
            found, wanted = counts.get(table, 0), end.counts.get(table, 0)
            if found != wanted:
                raise self._error(
                    f"the table {table} has {found} rows here and should have {wanted}"
                )
        if end.sha256 != self._digest.hexdigest():
            raise self._error("the backup isn't as it was written: its digest is another one")
        if line != encoded_end(counts, end.sha256):
            raise self._error("the backup's end was changed")
        if next(self._lines, None) is not None:
            raise self._error("there is something after the backup's end")
        self.sha256 = end.sha256

    def _row(self, line: bytes, tables: Mapping[str, Table]) -> Row:
        try:
            name, row = msgspec.json.decode(line, type=tuple[str, dict[str, Any]])
        except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
            raise self._error(f"a row can't be read: {error}") from error
        if name not in tables:
            raise self._error(f"there is no table {name[:60]!r}")
        columns = tables[name].columns
        if row.keys() != set(columns.keys()):
            raise self._error(f"a row of the table {name} has other columns")
        try:
            return name, {key: _stored(columns[key], value) for key, value in row.items()}
        except (TypeError, ValueError) as error:
            raise self._error(f"a row of the table {name} has a wrong value: {error}") from error

    def _read(self, file: BinaryIO) -> Iterator[bytes]:
        with gzip.GzipFile(fileobj=file, mode="rb") as lines:
            while True:
                try:
                    line = lines.readline(LONGEST_LINE)
                except gzip.BadGzipFile as error:
                    fix = TAKE_ANOTHER if self.line else "give a file of `ct annotate backup`"
                    raise self._error(f"the file can't be read: {error}", fix) from error
                except (OSError, EOFError, zlib.error) as error:
                    raise self._error(f"the file can't be read: {error}") from error
                if not line:
                    return
                self.line += 1
                if len(line) == LONGEST_LINE:
                    raise self._error("a line is longer than any of a backup")
                yield line

    def _error(self, what: str, fix: str = TAKE_ANOTHER) -> FormatError:
        where = f"{self.where}, line {self.line}" if self.line else self.where
        return FormatError(what, where=where, fix=fix)


def encoded_row(table: str, row: Mapping[Any, Any]) -> bytes:
    """Return a row as it is written."""
    plain = {
        str(name): base64.b64encode(value).decode() if isinstance(value, bytes) else value
        for name, value in row.items()
    }
    return msgspec.json.encode([table, plain]) + b"\n"


def encoded_end(counts: Mapping[str, int], sha256: str) -> bytes:
    """Return the last line as it is written."""
    return msgspec.json.encode(End(dict(sorted(counts.items())), sha256)) + b"\n"


def _stored(column: Column[Any], value: Any) -> Any:
    """Return a value as the database keeps it."""
    if value is None:
        if not column.nullable:
            raise TypeError(f"{column.name} is missing")
        return None
    if isinstance(column.type, LargeBinary):
        return base64.b64decode(value, validate=True)
    wanted = dict if isinstance(column.type, JSON) else column.type.python_type
    kinds = (int, float) if wanted is float else (wanted,)
    if type(value) not in kinds:
        raise TypeError(f"{column.name} is {type(value).__name__}, not {wanted.__name__}")
    return value


def _rows(session: Session) -> Iterator[Row]:
    for table in Base.metadata.sorted_tables:
        wanted = select(table).execution_options(yield_per=BATCH)
        for row in session.execute(wanted).mappings():
            if table.name == "secret" and row["name"] == DUE:
                continue  # what is to be done to this file
            yield str(table.name), dict(row)
