"""Writing a folder so that it is there as a whole or not at all."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Mapping
from pathlib import Path

from g3.errors import FormatError


def check_target(folder: Path, *, force: bool, marker: str) -> None:
    """Refuse to write over anything but an empty folder or, if forced, one with `marker`.

    Raises
    ------
    FormatError
        If `folder` is a file, holds something, or can't be made where it should be.
    """
    if not folder.parent.is_dir():
        raise FormatError("there is no such folder", where=str(folder.parent), fix="make it first")
    if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
        raise FormatError("this is not a folder", where=str(folder), fix="choose another name")
    if not folder.exists() or not any(folder.iterdir()):
        return
    if not (folder / marker).is_file():
        raise FormatError(
            f"the folder holds other things and no {marker}, so it is not replaced",
            where=str(folder),
            fix="choose another name, or empty it yourself",
        )
    if not force:
        raise FormatError(
            "the folder is there already",
            where=str(folder),
            fix="choose another name, or replace it with --force",
        )


def write_folder(folder: Path, files: Mapping[str, bytes], *, force: bool, marker: str) -> None:
    """Write files into a new folder, or in place of an old one that holds `marker`.

    The files are written to a temporary folder beside it and flushed to the disk before
    that takes the name; whatever happens, the name holds the old or the new content.
    """
    folder = Path(os.path.abspath(folder))  # noqa: PTH100 (resolve() would follow a symlink)
    check_target(folder, force=force, marker=marker)
    suffix = secrets.token_hex(4)
    new = folder.with_name(f".{folder.name}.new-{suffix}")
    old = folder.with_name(f".{folder.name}.old-{suffix}")
    try:
        new.mkdir()
        for name, content in files.items():
            _write_file(new / name, content)
        _flush_folder(new)
        if folder.exists():
            folder.rename(old)
        new.rename(folder)
        _flush_folder(folder.parent)
    finally:
        if old.exists() and not folder.exists():
            old.rename(folder)
        shutil.rmtree(new, ignore_errors=True)
        shutil.rmtree(old, ignore_errors=True)


def _write_file(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("xb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def _flush_folder(folder: Path) -> None:
    if os.name == "nt":  # where folders can't be opened
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
