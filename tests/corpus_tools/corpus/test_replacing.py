"""Folders that several programs write at once, or that a program writes when it is killed."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.runtime import atomic_folder as atomic
from g3.errors import FormatError
from g3.storage.only_writer import lock_of, only_writer
from tests.docs.small_warehouse import small_warehouse
from tests.tiny_corpus import tiny_corpus

KILLS = int(os.environ.get("CT_KILLS", "12"))
"""How often a writer is killed; more look for what is rare."""

WRITER = """
import itertools, os, signal, sys
from pathlib import Path
from corpus_tools.runtime import atomic_folder as atomic
folder, how = Path(sys.argv[1]), sys.argv[2]
if how != "exchange":
    atomic.exchange = lambda one, other: False
if how == "killed between":
    rename = Path.rename
    def once(path, target):
        rename(path, target)
        os.kill(os.getpid(), signal.SIGKILL)
    Path.rename = once
print("ready", flush=True)
for number in itertools.count():
    files = {name: b"%d" % number for name in ("corpus.json", "a/b", "c")}
    atomic.write_folder(folder, files, force=True, marker="corpus.json")
"""


@pytest.fixture
def folder(tmp_path):
    path = tmp_path / "x"
    write(path, b"first")
    return path


def write(path: Path, content: bytes, *, force: bool = True) -> None:
    files = dict.fromkeys(("corpus.json", "a/b", "c"), content)
    atomic.write_folder(path, files, force=force, marker="corpus.json")


def contents(path: Path) -> set[bytes]:
    return {file.read_bytes() for file in path.rglob("*") if file.is_file()}


@contextlib.contextmanager
def writer(path: Path, how: str):
    with subprocess.Popen(
        [sys.executable, "-c", WRITER, str(path), how], stdout=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        process.stdout.readline()
        try:
            yield process
        finally:
            process.kill()


def can_exchange(folder: Path) -> bool:
    one, other = folder.with_name("one"), folder.with_name("other")
    one.mkdir()
    other.mkdir()
    try:
        return atomic.exchange(one, other)
    finally:
        one.rmdir()
        other.rmdir()


def test_names_are_exchanged(folder, tmp_path):
    if not can_exchange(folder):
        pytest.skip("this file system can't")
    write(tmp_path / "y", b"second")
    assert atomic.exchange(folder, tmp_path / "y")
    assert (contents(folder), contents(tmp_path / "y")) == ({b"second"}, {b"first"})
    with pytest.raises(FileNotFoundError):
        atomic.exchange(folder, tmp_path / "nowhere")


def test_the_name_is_never_empty_whenever_a_writer_is_killed(folder):
    if not can_exchange(folder):
        pytest.skip("this file system can't")
    for number in range(KILLS):
        with writer(folder, "exchange") as process:
            end = time.monotonic() + 0.03 + 0.17 * number / KILLS
            while time.monotonic() < end:
                assert (folder / "corpus.json").exists()
            process.kill()
        assert folder.is_dir()
        assert len(contents(folder)) == 1, "parts of two"
    write(folder, b"last")
    assert contents(folder) == {b"last"}
    assert [path.name for path in folder.parent.iterdir()] == ["x"], "what they left is put away"


def test_without_exchange_the_next_one_restores_the_folder(folder):
    with writer(folder, "killed between") as process:
        assert process.wait(60) == -signal.SIGKILL
    assert not folder.exists()
    atomic.recover(folder)
    assert contents(folder) == {b"first"}
    with writer(folder, "killed between") as process:
        assert process.wait(60) == -signal.SIGKILL
    with pytest.raises(FormatError, match="the folder is there already"):
        write(folder, b"other", force=False)
    write(folder, b"other")
    assert contents(folder) == {b"other"}
    assert [path.name for path in folder.parent.iterdir()] == ["x"]


def test_reading_a_corpus_restores_it_too(tmp_path):
    tiny_corpus().save(tmp_path / "c")
    (tmp_path / "c").rename(tmp_path / ".c.old-0123abcd")
    assert Corpus.load(tmp_path / "c").name == "tiny"


def test_the_fallback_replaces_as_well(folder, monkeypatch):
    monkeypatch.setattr(atomic, "exchange", lambda _one, _other: False)
    write(folder, b"second")
    assert contents(folder) == {b"second"}
    assert [path.name for path in folder.parent.iterdir()] == ["x"]


def test_a_second_writer_is_told_and_a_killed_one_holds_nobody_up(folder):
    with only_writer(folder):
        with pytest.raises(FormatError, match=r"x: another program is writing this \(wait"):
            write(folder, b"second")
        assert contents(folder) == {b"first"}
    lock_of(folder).write_bytes(b"")  # of a program that was killed
    write(folder, b"second")
    assert contents(folder) == {b"second"}
    assert not lock_of(folder).exists()


IMPORT = """
import sys
from corpus_tools.cli import console
sys.exit(console.run(["import", "authored", *sys.argv[1:]]))
"""


@pytest.mark.parametrize("force", [False, True])
def test_of_three_imports_to_one_name_one_succeeds(tmp_path, force):
    """With --force, each that says it succeeded has; what is there at the end is one corpus."""
    source = small_warehouse(tmp_path / "source", ["hall_pick_up_boxes"])
    target = tmp_path / "target" / "x"
    target.parent.mkdir()
    arguments = [str(source), "--out", str(target)]
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", IMPORT, *arguments, *(["--force"] if force else [])],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        for _ in range(3)
    ]
    told = [process.communicate()[1] for process in processes]
    statuses = sorted(process.returncode for process in processes)
    assert Corpus.load(target).name == "warehouse"
    assert list(target.parent.iterdir()) == [target]
    assert set(statuses) <= {0, 2}, told
    assert statuses.count(0) >= 1 if force else statuses == [0, 2, 2], told
    for process, message in zip(processes, told, strict=True):
        if process.returncode:
            assert "another program is writing this" in message or "is there already" in message
