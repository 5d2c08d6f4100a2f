"""Opening the database: SQLite by default, PostgreSQL by URL."""

from __future__ import annotations

import functools
import os
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

from sqlalchemy import (
    Connection,
    Engine,
    SelectBase,
    Table,
    UpdateBase,
    create_engine,
    event,
    func,
    select,
)
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.dialects.postgresql import psycopg
from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError, DBAPIError, InvalidatePoolError, OperationalError
from sqlalchemy.orm import DeclarativeBase, Session

from annotation_app.database_file import keep_to
from g3.errors import FormatError

try:
    import fcntl
except ImportError:  # there is none on Windows
    fcntl = None  # type: ignore[assignment]

BUSY_S = 20
"""How long a writer waits for another one, in SQLite."""
IDLE_S = 5
"""A connection to PostgreSQL that wasn't used for so long is tried before it is used."""
_PATIENCE = {
    "connect_timeout": 5,
    "tcp_user_timeout": 15_000,
    "keepalives_idle": 10,
    "keepalives_interval": 5,
    "keepalives_count": 3,
}
"""After how long a server that doesn't answer is given up, as libpq takes it; URLs may differ."""
SET_UP = 0x63742D616E6E
"""Names the lock of those who set a database up, in PostgreSQL."""


def open_database(url_or_path: str | Path) -> Engine:
    """An engine for a database, which isn't connected to yet.

    Parameters
    ----------
    url_or_path
        Path of a SQLite file, or a URL such as ``postgresql://user@host/name``.

    Raises
    ------
    FormatError
        If it is a URL that can't be read.
    """
    url = _url(url_or_path)
    if url.get_backend_name() != "sqlite":
        engine = create_engine(
            url,
            isolation_level="AUTOCOMMIT",
            pool_size=10,
            max_overflow=20,
            hide_parameters=True,
            connect_args={name: n for name, n in _PATIENCE.items() if name not in url.query},
        )
        event.listen(engine, "checkin", _note_use)
        event.listen(engine, "checkout", _check_if_idle)
    else:
        engine = create_engine(
            url, connect_args={"timeout": BUSY_S, "check_same_thread": False}, hide_parameters=True
        )
        event.listen(engine, "connect", _set_up_sqlite)
        if url.database and url.database != ":memory:":
            keep_to(engine, Path(url.database))
    event.listen(engine, "begin", _begin)
    return engine


@contextmanager
def opened(url_or_path: str | Path) -> Iterator[Engine]:
    """A database whose connections are closed at the end; see :func:`open_database`."""
    engine = open_database(url_or_path)
    try:
        yield engine
    finally:
        engine.dispose()


@contextmanager
def transaction(engine: Engine) -> Iterator[Session]:
    """A session that is committed at the end, or rolled back by an exception.

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
    """A session that only reads, beside whoever writes.

    Parameters
    ----------
    one_state
        Whether all that is read must be of one moment. In SQLite it always is; PostgreSQL is
        spared work where each statement may see what has come since the last.
    """
    with engine.connect() as connection:
        connection.execution_options(to="read one state" if one_state else "read")
        with Session(connection, expire_on_commit=False) as session:
            yield session


@contextmanager
def _turn(engine: Engine) -> Iterator[None]:
    """Wait for one's turn to write to an SQLite file, in this process or another.

    SQLite has only one writer at a time, and those who wait look again after ever longer
    pauses; the kernel wakes the next one at once, and when a process dies.
    """
    file = engine.url.database
    if fcntl is None or engine.dialect.name != "sqlite" or not file:
        yield
        return
    try:
        descriptor = os.open(f"{file}-turn", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
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


def _set_up_sqlite(connection: Any, _record: Any) -> None:
    # SQLAlchemy's documented recipe: the driver must not begin transactions by itself.
    connection.isolation_level = None
    for pragma in ("journal_mode=WAL", "synchronous=FULL", "foreign_keys=ON"):
        connection.execute(f"PRAGMA {pragma}")


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
        with _known_errors(connection, statement):
            connection.connection.cursor().execute(statement)


_BEGIN = {
    # A transaction that reads first and writes later could fail where another has written.
    ("sqlite", "write"): "BEGIN IMMEDIATE",
    ("sqlite", "read"): "BEGIN",
    ("sqlite", "read one state"): "BEGIN",
    ("postgresql", "write"): "BEGIN",
    ("postgresql", "read one state"): "BEGIN ISOLATION LEVEL REPEATABLE READ",
}


def connection_of(session: Session) -> Connection:
    """The connection of a session of this module; what the session holds must be flushed before."""
    return cast("Connection", session.bind)


def run(
    session: Session, statement: SelectBase | UpdateBase, values: Mapping[str, Any]
) -> Sequence[Any]:
    """Run a statement with the driver alone, and give its rows. It takes half of the time.

    What the session holds must be flushed before. Values and rows are the driver's, so that
    JSON is text.
    """
    connection = connection_of(session)
    text, fixed = _compiled(statement, connection.dialect.name)
    with _known_errors(connection, text):
        cursor = connection.connection.cursor()
        cursor.execute(text, {**fixed, **values})
        return cursor.fetchall()


@contextmanager
def _known_errors(connection: Connection, text: str) -> Iterator[None]:
    """Raise the driver's errors as SQLAlchemy does, and give a broken connection up."""
    dialect = connection.dialect
    driver_error = dialect.loaded_dbapi.Error
    try:
        yield
    except driver_error as error:
        is_broken = dialect.is_disconnect(error, connection.connection.dbapi_connection, None)
        if is_broken:
            connection.invalidate(error)
            connection.engine.dispose()  # the others that wait are as old
        raise DBAPIError.instance(
            text,
            None,
            error,
            driver_error,
            hide_parameters=True,
            connection_invalidated=is_broken,
            dialect=dialect,
        ) from error


@functools.cache
def _compiled(statement: SelectBase | UpdateBase, dialect: str) -> tuple[str, Mapping[str, Any]]:
    compiled = statement.compile(dialect=_DIALECTS[dialect])
    return compiled.string, compiled.params


_DIALECTS = {
    "sqlite": sqlite.dialect(paramstyle="named"),
    "postgresql": psycopg.dialect(),  # type: ignore[no-untyped-call]
}


def core(table: type[DeclarativeBase]) -> Table:
    """A table itself, for statements that make no objects: they take half the time."""
    return cast("Table", table.__table__)


def dialect_of(session: Session) -> str:
    """Which kind of database it is: ``sqlite`` or ``postgresql``."""
    return session.get_bind().dialect.name


def inserting(dialect: str, table: type[DeclarativeBase]) -> Any:
    """A statement that inserts, and may tell what to do where there is such a row already.

    Both databases have the same words for that, and SQLAlchemy a statement for each.
    """
    return _INSERTS[dialect](core(table))


_INSERTS: dict[str, Any] = {"sqlite": sqlite.insert, "postgresql": postgresql.insert}
