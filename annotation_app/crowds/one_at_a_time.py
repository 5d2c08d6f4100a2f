"""One program at a time offers, approves and pays a study's work at the platforms."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import sha256

from sqlalchemy import Engine, func, select

from g3.errors import CorpusError

try:
    import fcntl
except ImportError:  # there is none on Windows
    fcntl = None  # type: ignore[assignment]


@contextmanager
def one_at_a_time(engine: Engine, study_id: str) -> Iterator[None]:
    """Keep other programs from a study's platforms.

    The lock ends with the process, however that ends. So whoever holds it knows that calls
    which the ledger has as attempted are nobody's any more. On Windows an SQLite database has
    no such lock; there the ledger's own rows keep two programs from paying the same bonus.

    Raises
    ------
    CorpusError
        If another program has the lock.
    """
    locked = _server_lock if engine.dialect.name == "postgresql" else _file_lock
    with locked(engine, study_id) as is_mine:
        if not is_mine:
            raise CorpusError(
                "another `ct crowd publish` or `ct crowd collect` is at work on this study",
                fix="wait until it is done",
            )
        yield


@contextmanager
def _file_lock(engine: Engine, _study_id: str) -> Iterator[bool]:
    if fcntl is None:
        yield True
        return
    file = f"{engine.url.database}-platforms"
    descriptor = os.open(file, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            yield False
        else:
            yield True
    finally:
        os.close(descriptor)


@contextmanager
def _server_lock(engine: Engine, study_id: str) -> Iterator[bool]:
    name = int.from_bytes(sha256(f"platforms {study_id}".encode()).digest()[:8], "big", signed=True)
    with engine.connect() as connection:
        connection.execution_options(to="read")
        is_mine = bool(connection.scalar(select(func.pg_try_advisory_lock(name))))
        try:
            yield is_mine
        finally:
            if is_mine:
                connection.scalar(select(func.pg_advisory_unlock(name)))
