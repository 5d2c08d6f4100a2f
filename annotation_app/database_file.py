"""Holding on to the file of an SQLite database, so that nothing is written where nobody reads it.

A program that has a file open goes on writing to it when it is moved or deleted, and SQLite makes a
new, empty file where there is none. Both would lose answers that were acknowledged.
"""

from __future__ import annotations

import sqlite3
from pathlib import Path
from typing import Any

from sqlalchemy import Engine, event
from sqlalchemy.exc import DisconnectionError


def keep_to(engine: Engine, file: Path) -> None:
    """Use connections only while the file that they have open is the one with this name.

    The first connection may make the file; later ones fail where it is gone.
    """
    known: list[Path] = []

    def connect(_dialect: Any, _record: Any, _arguments: Any, _options: Any) -> None:
        if known and not file.exists():
            raise sqlite3.OperationalError("unable to open database file: it was moved or deleted")

    def connected(_connection: Any, record: Any) -> None:
        record.info["file"] = _identity(file)
        if not known:
            known.append(file)

    def check(_connection: Any, record: Any, _proxy: Any) -> None:
        if record.info["file"] != _identity(file):
            raise DisconnectionError("the database's file was moved, deleted or replaced")

    event.listen(engine, "do_connect", connect)
    event.listen(engine, "connect", connected)
    event.listen(engine, "checkout", check)


def _identity(file: Path) -> tuple[int, int] | None:
    try:
        found = file.stat()
    except OSError:
        return None
    return found.st_dev, found.st_ino
