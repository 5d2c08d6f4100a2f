"""Databases that can only be read: what reads works, and what writes says why it can't."""

from __future__ import annotations

import ctypes
import os
import shutil
import sqlite3
import stat
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from flask import Flask

from tests.annotation_app.browser import Browser, described, engine_of, installation_of

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="rights as on Linux")
ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture
def folder(app: Flask) -> Iterator[Path]:
    """An instance in which somebody has answered."""
    Browser(app).do("describe", described("Go there"))
    engine_of(app).dispose()
    made = installation_of(app).config.instance
    yield made
    made.chmod(0o700)


def as_somebody(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Run a command as somebody whom rights bind, which they don't bind root."""
    command = [sys.executable, "-m", "corpus_tools", "annotate", *arguments]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(
        command, env=environment, capture_output=True, text=True, check=False,
        errors="replace", preexec_fn=give_up_rights,
    )  # fmt: skip


def give_up_rights() -> None:
    """Let the program that this process becomes pass over no file's rights."""
    libc = ctypes.CDLL(None)
    for capability in (1, 2):  # CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH
        libc.prctl(24, capability, 0, 0, 0)  # PR_CAPBSET_DROP


@pytest.mark.slow
@pytest.mark.parametrize("is_folder_writable", [False, True])
def test_a_read_only_database_is_exported(folder: Path, is_folder_writable: bool) -> None:
    for file in folder.iterdir():
        if file.is_file():
            file.chmod(0o444)
    folder.chmod(0o777 if is_folder_writable else 0o555)
    out = Path("/dev/stdout")
    told = as_somebody("export", str(out), "--format", "jsonl", "--instance", str(folder))
    assert told.returncode == 0, told.stderr
    assert "Go there" in told.stdout
    told = as_somebody("backup", "/dev/stdout", "--without-keys", "--instance", str(folder))
    assert told.returncode == 0, told.stderr
    told = as_somebody("people", "erase", "0123456789ab", "--yes", "--instance", str(folder))
    assert told.returncode == 2
    assert "the database can only be read" in told.stderr
    told = as_somebody("export", str(out), "--format", "jsonl", "--instance", "/proc/nothing")
    assert told.returncode == 2
    assert "/proc/nothing: there is no installation here" in told.stderr


@pytest.mark.slow
def test_answers_that_are_in_the_log_only_are_not_left_out(folder: Path) -> None:
    """Rather than without them it isn't read at all."""
    database = folder / "annotation.sqlite"
    with closing(sqlite3.connect(database, isolation_level=None)) as connection:
        connection.execute("PRAGMA wal_autocheckpoint=0")
        connection.execute('UPDATE answer SET body = \'{"text": "Newer"}\'')
        copy = folder / "copy"
        copy.mkdir()
        for name in ("annotation.sqlite", "annotation.sqlite-wal", "secret-key"):
            shutil.copy(folder / name, copy / name)
    assert (copy / "annotation.sqlite-wal").stat().st_size
    for file in copy.iterdir():
        file.chmod(stat.S_IRUSR | stat.S_IRGRP | stat.S_IROTH)
    copy.chmod(0o555)
    told = as_somebody("export", "/dev/stdout", "--format", "jsonl", "--instance", str(copy))
    copy.chmod(0o700)
    assert told.returncode == 2, told
    assert "the newest rows are in the log beside it" in told.stderr
    told = as_somebody("export", "/dev/stdout", "--format", "jsonl", "--instance", str(copy))
    assert "Newer" in told.stdout, told
