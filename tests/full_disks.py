"""A disk without room, to write to: a small file system, or files that may not grow."""

from __future__ import annotations

import contextlib
import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

SIZE_KB = 64


@contextlib.contextmanager
def full_disk(folder: Path, *, free_bytes: int = 0) -> Iterator[Path]:
    """A file system of 64 KB on `folder` that has no more room than `free_bytes`.

    The test is skipped where none can be mounted, which takes the rights of root.
    """
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", f"size={SIZE_KB}k", "tmpfs", str(folder)]
    try:
        made = subprocess.run(command, check=False, capture_output=True, text=True)
    except FileNotFoundError:
        pytest.skip("there is no program to mount a small disk with")
    if made.returncode:
        pytest.skip(f"a small disk can't be mounted: {made.stderr.strip()}")
    try:
        with (folder / "filler").open("wb", buffering=0) as file, contextlib.suppress(OSError):
            while file.write(bytes(4096)):
                pass
        size = (folder / "filler").stat().st_size
        os.truncate(folder / "filler", max(0, size - free_bytes))
        yield folder
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


def left_in(folder: Path) -> list[str]:
    """The names of all files there, hidden ones too, but not the filler."""
    return sorted(
        str(path.relative_to(folder))
        for path in folder.rglob("*")
        if path.is_file() and path.name != "filler"
    )
