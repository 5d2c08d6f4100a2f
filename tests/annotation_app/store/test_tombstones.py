"""Restored backups don't bring back whose data were erased."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from flask import Flask
from sqlalchemy import func, select

from annotation_app.copies.backups import back_up
from annotation_app.core.config import open_instance
from annotation_app.core.key_file import KEY_FILE
from annotation_app.serving.factory import create_app
from annotation_app.store.audit import RESTORED
from annotation_app.store.database import opened, reading
from annotation_app.store.models import Answer, AuditEntry, Erasure
from annotation_app.store.tombstones import ERASED_FILE, Tombstone, read_tombstones
from corpus_tools.cli.console import run
from g3.errors import FormatError
from tests.annotation_app.browser import Browser, described, installation_of
from tests.annotation_app.privacy.test_erasure import BOTH, code_of, command, worked

__all__ = ["worked"]


@BOTH
def test_a_restored_backup_does_not_bring_them_back(
    app: Flask, worked: tuple[Browser, Browser], tmp_path: Path, capsys: Any
) -> None:
    ada, bob = worked
    config = installation_of(app).config
    early, late = tmp_path / "early.gz", tmp_path / "late.gz"
    back_up(config, early, None)
    assert run(command(app, "people", "erase", code_of(app, ada), "--yes")) == 0
    back_up(config, late, None)
    keys = ["--keys", str(config.instance / KEY_FILE)]
    tombs = tmp_path / "kept-elsewhere.jsonl"
    (config.instance / ERASED_FILE).rename(tombs)

    def restored(archive: Path, name: str, *given: str) -> tuple[str, bool]:
        capsys.readouterr()
        folder = tmp_path / name
        where = ["--instance", str(folder), *keys]
        assert run(["annotate", "restore", str(archive), *where, *given]) == 0
        engine_files = b"".join(f.read_bytes() for f in folder.iterdir() if f.is_file())
        return capsys.readouterr().out, b"zebra" in engine_files

    assert restored(late, "late")[1] is False
    assert restored(early, "brings-back")[1] is True
    said, is_there = restored(early, "named", "--erased", str(tombs))
    assert is_there is False
    assert "erased again: the data of 1 of 1 people" in said
    tombs.rename(tmp_path / ERASED_FILE)  # beside the archive
    said, is_there = restored(early, "found")
    assert is_there is False
    assert "erased again: the data of 1 of 1 people" in said
    made = open_instance(tmp_path / "found")
    assert [t.person for t in read_tombstones(made.instance / ERASED_FILE)] == [ada.person.id]
    with opened(made.database) as engine, reading(engine) as session:
        assert session.scalars(select(Erasure.person_id)).all() == [ada.person.id]
        entries = {entry.action: entry.about for entry in session.scalars(select(AuditEntry))}
        assert entries["erased a person's data again"] == ada.person.id
        assert entries.keys() == {"erased a person's data again", RESTORED}
        assert session.scalar(select(func.count()).where(Answer.person_id == bob.person.id))
    with opened(made.database) as engine:
        Browser(create_app(made, engine)).do("describe", described("Pick up the hat"))


def test_damaged_tombstones_are_named(tmp_path: Path) -> None:
    file = tmp_path / "erased.jsonl"
    for content in ("{", '{"person": 1, "at": 2}', '{"person": "a"}', "\xff"):
        file.write_bytes(b'{"person": "a", "at": 1.0}\n\n' + content.encode("latin-1"))
        with pytest.raises(FormatError, match=r"erased.jsonl:3:\d+: "):
            read_tombstones(file)
    file.write_text('{"person": "a", "at": 1.0}\n\n')
    assert read_tombstones(file) == [Tombstone("a", 1.0)]
