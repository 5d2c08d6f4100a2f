"""Backups: a file that holds every row of a database, whichever kind of database it is."""

from __future__ import annotations

import gzip
import hashlib
import time
from collections.abc import Iterator
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.copies.backup_file import (
    LEVEL,
    VERSION,
    Head,
    Row,
    encoded_end,
    encoded_head,
    encoded_row,
)
from annotation_app.core.config import Config
from annotation_app.core.key_file import Keys
from annotation_app.core.sealed_keys import seal
from annotation_app.store.compaction import DUE
from annotation_app.store.database import opened, reading
from annotation_app.store.models import Base
from annotation_app.store.salt import SALT, installation_salt
from annotation_app.store.schema import NEWEST, is_current
from g3.errors import FormatError
from g3.storage.atomic_file import replacing

_BATCH = 1000


def back_up(config: Config, archive: Path, passphrase: str | None) -> int:
    """Write all rows to a file that only its owner may read, from the moment it is made.

    It holds one moment of the database, which may be served meanwhile.

    Parameters
    ----------
    passphrase
        What the key and the salt are encrypted with; if there is none they are left out.

    Returns
    -------
    int
        How many rows it holds.

    Raises
    ------
    FormatError
        If there is no database of this program's, or the passphrase is too short.
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
            line = encoded_head(head)
            digest.update(line)
            lines.write(line)
            for table, row in _rows(session):
                line = encoded_row(table, row)
                digest.update(line)
                lines.write(line)
                counts[table] += 1
            lines.write(encoded_end(counts, digest.hexdigest()))
    return sum(counts.values())


def _rows(session: Session) -> Iterator[Row]:
    for table in Base.metadata.sorted_tables:
        wanted = select(table).execution_options(yield_per=_BATCH)
        for row in session.execute(wanted).mappings():
            if table.name == "secret" and row["name"] in (SALT, DUE):
                continue  # what an older program has left, and what is to be done to this file
            yield str(table.name), dict(row)
