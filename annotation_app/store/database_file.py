"""Holding on to the file of an SQLite database, so that nothing is written where nobody reads it.

A program that has a file open goes on writing to it when it is moved or deleted; where there is no
file, SQLite makes an empty one. It also reads what was just written to one file into another that
was put in its place. All of that would lose answers that were acknowledged.
"""

from __future__ import annotations

import sqlite3
from pathlib import Path
from typing import Any

from sqlalchemy import Engine, event
from sqlalchemy.exc import DisconnectionError


def keep_to(engine: Engine, file: Path) -> None:
    """Use the file that was opened first, which may be made then, as long as it is in its place."""
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
