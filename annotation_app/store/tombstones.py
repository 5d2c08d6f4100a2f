"""Records of erased people, beside the database: restored backups must not bring their data back.

``erased.jsonl`` in the instance's folder has a line for each person, with their id, which is
random and says nothing of them. It holds what the table ``erasure`` does, and is meant to be kept
where the database's end doesn't reach it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from itertools import chain
from pathlib import Path

import msgspec
from sqlalchemy import Engine, select

from annotation_app.store.database import reading
from annotation_app.store.models import Erasure
from corpus_tools.tables.json_text import json_lines
from g3.storage.atomic_file import write_bytes

ERASED_FILE = "erased.jsonl"


class Tombstone(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A record that a person's data were erased."""

    person: str
    at: float


def read_tombstones(file: Path) -> list[Tombstone]:
    """Read the lines of such a file; a FormatError if it isn't one."""
    fix = 'each line is such as {"person": "…", "at": 1.0}; use another copy of the file'
    return [tombstone for _, tombstone in json_lines(file, Tombstone, fix=fix)]


def find_tombstones(archive: Path, instance: Path) -> list[Path]:
    """Return such files in their usual places: beside a backup, and in or beside an instance."""
    folders = dict.fromkeys((archive.absolute().parent, instance, instance.absolute().parent))
    return [file for folder in folders if (file := folder / ERASED_FILE).is_file()]


def keep(engine: Engine, instance: Path) -> None:
    """Bring an instance's file up to date with its database; lines are never taken away."""
    with reading(engine) as session:
        rows = session.scalars(select(Erasure).order_by(Erasure.at)).all()
    known = [Tombstone(row.person_id, row.at) for row in rows]
    file = instance / ERASED_FILE
    before = read_tombstones(file) if file.exists() else []
    after = joined(before, known)
    if len(after) > len(before):
        lines = [msgspec.json.encode(tombstone) + b"\n" for tombstone in after.values()]
        write_bytes(file, b"".join(lines), private=True)


def joined(*groups: Collection[Tombstone]) -> Mapping[str, Tombstone]:
    """Return tombstones by person, the first of each."""
    found: dict[str, Tombstone] = {}
    for tombstone in chain.from_iterable(groups):
        found.setdefault(tombstone.person, tombstone)
    return found
