"""Opening the database: SQLite by default, PostgreSQL by URL."""

from __future__ import annotations

import json
import os
import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, cast

import msgspec
from sqlalchemy import (
    Connection,
    Dialect,
    Engine,
    Table,
    create_engine,
    event,
    func,
    select,
)
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import (
    ArgumentError,
    DisconnectionError,
    InvalidatePoolError,
    OperationalError,
    SQLAlchemyError,
)
from sqlalchemy.orm import DeclarativeBase, Session

from annotation_app.store.outages import (
    OnlyReadError as OnlyReadError,  # noqa: PLC0414 - who opens databases catches it
)
from annotation_app.store.outages import named_outage
from g3.errors import FormatError

try:
    import fcntl
except ImportError:  # there is none on Windows
    fcntl = None  # type: ignore[assignment]

BEFORE_FIRST = "what is from before version 0.2.0 is brought up to date by that version first"
BUSY_S = 20
"""Longest wait of a writer for another one, in SQLite, in seconds."""
CHECKPOINT_S = 3
"""Longest wait of a checkpoint of SQLite's log for readers, in seconds."""
IDLE_S = 5
"""A connection to PostgreSQL that wasn't used for so long is tried before it is used."""
_PATIENCE = {
    "connect_timeout": 5,
    "tcp_user_timeout": 15_000,
    "keepalives_idle": 10,
    "keepalives_interval": 5,
    "keepalives_count": 3,
}
"""Time after which a silent server is given up, as libpq takes it; URLs may differ."""
SET_UP = 0x63742D616E6E
"""Names the lock of those who set a database up, in PostgreSQL."""


def open_database(url_or_path: str | Path) -> Engine:
    """Return an engine for a database, which isn't connected to yet.

    It is a SQLite file, or a URL such as ``postgresql://user@host/name``; a FormatError says that
    this can't be read.
    """
    url = _url(url_or_path)
    if url.get_backend_name() != "sqlite":
        engine = create_engine(
            url,
            isolation_level="AUTOCOMMIT",
            pool_size=10,
            max_overflow=20,
            hide_parameters=True,
            json_deserializer=decoded,
            connect_args={name: n for name, n in _PATIENCE.items() if name not in url.query},
        )
        event.listen(engine, "checkin", _note_use)
        event.listen(engine, "checkout", _check_if_idle)
    else:
        engine = create_engine(
            url,
            connect_args={"timeout": BUSY_S, "check_same_thread": False},
            hide_parameters=True,
            json_deserializer=decoded,
        )
        if url.database and url.database != ":memory:":
            _keep_to(engine, Path(url.database))
        event.listen(engine, "do_connect", _connect_to_file)  # after the check, for it connects
    event.listen(engine, "begin", _begin)
    return engine


@contextmanager
def opened(url_or_path: str | Path) -> Iterator[Engine]:
    """Yield a database whose connections are closed at the end; see :func:`open_database`.

    Raises
    ------
    FormatError
        If the database can't be reached, read or written: it is named, and what to do.
    """
    engine = open_database(url_or_path)
    try:
        yield engine
    except SQLAlchemyError as error:
        url = engine.url
        is_file = url.get_backend_name() == "sqlite" and url.database
        where = str(url.database) if is_file else url.render_as_string(hide_password=True)
        outage = named_outage(error, where)
        raise outage or error from error
    finally:
        engine.dispose()


@contextmanager
def transaction(engine: Engine) -> Iterator[Session]:
    """Yield a session that is committed at the end, or rolled back by an exception.

    There must not be another one within it.
    """
    with (
        _turn(engine),
        engine.begin() as connection,
        Session(connection, expire_on_commit=False) as session,
    ):
        yield session
        session.flush()


def lock_set_up(connection: Connection) -> None:
    """Let no other process set the database up until this transaction ends."""
    if connection.dialect.name == "postgresql":  # SQLite has one writer at a time
        connection.execute(select(func.pg_advisory_xact_lock(SET_UP)))


@contextmanager
def reading(engine: Engine, *, one_state: bool = False) -> Iterator[Session]:
    """Yield a session that only reads, beside writers.

    If all reads must be of `one_state`, the database works more than where each statement may
    see changes since the last.
    """
    with engine.connect() as connection:
        connection.execution_options(to="read one state" if one_state else "read")
        with Session(connection, expire_on_commit=False) as session:
            yield session


def compact(engine: Engine, *tables: str) -> bool:
    """Rewrite tables, so that nothing that was deleted is left in their files.

    In SQLite it is the whole file. Others wait meanwhile, some seconds for a gigabyte.

    It is False if it wasn't done: others who read may keep SQLite's log from being emptied.
    """
    with _turn(engine), engine.connect() as connection:
        connection.execution_options(to="begin nothing")
        if engine.dialect.name == "postgresql":
            connection.exec_driver_sql(f"SET lock_timeout = '{BUSY_S}s'")
            try:
                connection.exec_driver_sql(f"VACUUM FULL {', '.join(tables)}")
            finally:
                connection.exec_driver_sql("RESET lock_timeout")
            return True
        connection.exec_driver_sql("VACUUM")
        # Who reads all the time must not keep who writes waiting.
        connection.exec_driver_sql(f"PRAGMA busy_timeout={CHECKPOINT_S * 1000}")
        (blocked, _, _) = connection.exec_driver_sql("PRAGMA wal_checkpoint(TRUNCATE)").one()
        connection.exec_driver_sql(f"PRAGMA busy_timeout={BUSY_S * 1000}")
        return not blocked


@contextmanager
def _turn(engine: Engine) -> Iterator[None]:
    """Wait for one's turn to write to an SQLite file, in this process or another.

    SQLite has only one writer at a time, and those who wait look again after ever longer
    pauses. The kernel wakes the next one at once, and when a process dies.
    """
    file = engine.url.database
    if fcntl is None or engine.dialect.name != "sqlite" or not file:
        yield
        return
    if not os.access(file, os.W_OK) and os.access(file, os.R_OK):
        raise OnlyReadError(file)
    try:
        descriptor = os.open(f"{file}-turn", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    except PermissionError:
        raise OnlyReadError(file) from None
    except OSError as error:
        raise OperationalError(None, None, error) from error
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def _url(url_or_path: str | Path) -> URL:
    given = str(url_or_path)
    if "://" not in given:
        return URL.create("sqlite", database=given)
    try:
        url = make_url(given)
    except ArgumentError as error:
        raise FormatError(
            f"the database's URL can't be read: {error}",
            where=given.rsplit("@", maxsplit=1)[-1],
            fix="give a file, or a URL such as postgresql://user@host/name",
        ) from error
    return url.set(drivername="postgresql+psycopg") if url.drivername == "postgresql" else url


def decoded(text: str | bytes) -> Any:
    """Decode JSON, several times as fast as the standard library, and with the same result."""
    try:
        return msgspec.json.decode(text)
    except msgspec.DecodeError:  # NaN, half a character: Python has written those
        return json.loads(text)


def _connect_to_file(dialect: Dialect, _record: Any, names: Any, options: Any) -> Any:
    """Open an SQLite file, made for its owner alone if it isn't there; to read, if it must be."""
    (file,) = names
    if not file or file.startswith((":memory:", "file:")):
        return _set_up_sqlite(dialect.connect(file, **options))
    with suppress(OSError):  # if it can't be made, the driver says so
        os.close(os.open(file, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600))
    try:
        return _set_up_sqlite(dialect.connect(file, **options))
    except sqlite3.OperationalError:
        writable = (os.access(path, os.W_OK) for path in (file, Path(file).absolute().parent))
        if all(writable) or not os.access(file, os.R_OK):
            raise
    options = {**options, "uri": True}
    address = f"{Path(file).resolve().as_uri()}?mode=ro"
    try:
        return _tried(dialect.connect(address, **options))
    except sqlite3.OperationalError:
        log = Path(f"{file}-wal")
        if log.exists() and log.stat().st_size:  # what it holds would be missing
            raise OnlyReadError(file, "the newest rows are in the log beside it") from None
    # Nobody can write, so that no locks are needed, nor the files that hold them.
    return _tried(dialect.connect(f"{address}&immutable=1", **options))


def _keep_to(engine: Engine, file: Path) -> None:
    """Use the file that was opened first, which may be made then, as long as it is in its place.

    A program that has a file open still writes to it when it is moved or deleted; where there is
    no file, SQLite makes an empty one. It also reads what was just written to one file into another
    that was put in its place. All of that would lose answers that were acknowledged.
    """
    first: list[tuple[int, int] | None] = []

    def is_there() -> bool:
        return not first or _identity(file) == first[0]

    def connect(_dialect: Any, _record: Any, _arguments: Any, _options: Any) -> None:
        if not is_there():
            raise sqlite3.OperationalError(
                "unable to open database file: it was moved, deleted or replaced; put it back"
            )

    def connected(_connection: Any, _record: Any) -> None:
        if not first:
            first.append(_identity(file))

    def check(_connection: Any, _record: Any, _proxy: Any) -> None:
        if not is_there():
            raise DisconnectionError

    event.listen(engine, "do_connect", connect)
    event.listen(engine, "connect", connected)
    event.listen(engine, "checkout", check)


def _identity(file: Path) -> tuple[int, int] | None:
    try:
        found = file.stat()
    except OSError:
        return None
    return found.st_dev, found.st_ino


def _set_up_sqlite(connection: Any) -> Any:
    pragmas = ("journal_mode=WAL", "synchronous=FULL", "foreign_keys=ON", "secure_delete=FAST")
    return _tried(connection, *(f"PRAGMA {pragma}" for pragma in pragmas))


def _tried(connection: Any, *statements: str) -> Any:
    """Return a connection on which statements succeed; it is closed if one doesn't."""
    # SQLAlchemy's documented recipe: the driver must not begin transactions by itself.
    connection.isolation_level = None
    try:
        for statement in statements or ("SELECT count(*) FROM sqlite_master",):
            connection.execute(statement).fetchone()
    except sqlite3.Error:
        connection.close()
        raise
    return connection


def _note_use(_connection: Any, record: Any) -> None:
    record.info["used_at"] = time.monotonic()


def _check_if_idle(connection: Any, record: Any, _proxy: Any) -> None:
    """Find out whether a connection that wasn't used for a while still is one.

    Asking each time, as ``pool_pre_ping`` does, takes a sixth of a request's time.
    """
    if time.monotonic() - record.info.get("used_at", time.monotonic()) < IDLE_S:
        return
    try:
        with connection.cursor() as cursor:
            cursor.execute("SELECT 1")
        connection.rollback()
    except Exception as error:
        raise InvalidatePoolError("the server has closed the connection") from error


def _begin(connection: Connection) -> None:
    # Drivers begin no transactions by themselves: not each needs one, and to have them told
    # which do costs more than to tell the database.
    what = connection.get_execution_options().get("to", "write")
    statement = _BEGIN.get((connection.dialect.name, what))
    if statement is not None:
        connection.exec_driver_sql(statement)


_BEGIN = {
    # A transaction that reads first and writes later could fail where another has written.
    ("sqlite", "write"): "BEGIN IMMEDIATE",
    ("sqlite", "read one state"): "BEGIN",
    ("postgresql", "write"): "BEGIN",
    ("postgresql", "read one state"): "BEGIN ISOLATION LEVEL REPEATABLE READ",
}


def core(table: type[DeclarativeBase]) -> Table:
    """Return a table itself, for statements that make no objects: they take half the time."""
    return cast("Table", table.__table__)


def dialect_of(session: Session) -> str:
    """Return the kind of database: ``sqlite`` or ``postgresql``."""
    return session.get_bind().dialect.name


def inserting(dialect: str, table: type[DeclarativeBase]) -> Any:
    """Return a statement that inserts, and may resolve conflicts with existing rows.

    Both databases have the same words for that, and SQLAlchemy a statement for each.
    """
    return _INSERTS[dialect](core(table))


_INSERTS: dict[str, Any] = {"sqlite": sqlite.insert, "postgresql": postgresql.insert}
