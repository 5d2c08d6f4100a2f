"""Files are written wholly or not at all, and private ones are never anybody else's."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from g3.errors import FormatError
from g3.storage.atomic_file import write_bytes


def test_a_file_is_replaced_and_nothing_else_is_left(tmp_path):
    write_bytes(tmp_path / "a", b"old")
    write_bytes(tmp_path / "a", b"new")
    assert [(p.name, p.read_bytes()) for p in tmp_path.iterdir()] == [("a", b"new")]


def test_a_folder_that_is_not_there_is_an_error(tmp_path):
    with pytest.raises(FormatError, match="there is no such folder"):
        write_bytes(tmp_path / "no" / "a", b"")


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such rights")
def test_a_private_file_is_its_owners_from_its_first_byte_on(tmp_path, monkeypatch):
    """Looked at while it is written, over a file that all may read, under a loose umask."""
    seen = []
    real = os.fsync

    def looked_at(descriptor: int) -> None:
        seen.extend(stat.S_IMODE(path.stat().st_mode) for path in tmp_path.glob(".a.new-*"))
        real(descriptor)

    monkeypatch.setattr(os, "fsync", looked_at)
    previous = os.umask(0)
    try:
        (tmp_path / "a").write_bytes(b"old")
        write_bytes(tmp_path / "b", b"open")
        write_bytes(tmp_path / "a", b"secret", private=True)
    finally:
        os.umask(previous)

    def mode(path: Path) -> int:
        return stat.S_IMODE(path.stat().st_mode)

    assert (tmp_path / "a").read_bytes() == b"secret"
    assert seen == [0o600]
    assert (mode(tmp_path / "a"), mode(tmp_path / "b")) == (0o600, 0o666)
