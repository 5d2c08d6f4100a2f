"""Seeing to it that what was deleted is in no file of the database any more.

That it is to be done is noted where something is deleted, in the same transaction. So it is done
at the next start at the latest, if a crash, a full disk or somebody who reads stops it now.
"""

from __future__ import annotations

from sqlalchemy import Engine, delete
from sqlalchemy.exc import OperationalError
from sqlalchemy.orm import Session

from annotation_app.store.database import compact, reading, transaction
from annotation_app.store.models import Base, Secret

DUE = "files hold what was deleted"
"""Name under which the need to compact is noted."""


def ask(session: Session) -> None:
    """Note that something was deleted that no file must hold."""
    session.merge(Secret(name=DUE, value=b""))


def compact_if_asked(engine: Engine) -> bool:
    """Rewrite the tables if no file may keep deleted data; return whether none does."""
    with reading(engine) as session:
        if session.get(Secret, DUE) is None:
            return True
    try:
        done = compact(engine, *(str(table.name) for table in Base.metadata.sorted_tables))
    except OperationalError:  # locked for too long, or the disk is full
        return False
    if done:
        with transaction(engine) as session:
            session.execute(delete(Secret).where(Secret.name == DUE))
    return done
