"""Writing a folder so that it is there as a whole or not at all.

A folder that is replaced exchanges its name with the new one in one step. Where the system or the
file system can't do that, it is renamed away first (``.NAME.old-…``). A program that is killed
before the second renaming leaves the name empty, and the next to read or write the folder restores
it.
"""

from __future__ import annotations

import ctypes
import errno
import functools
import os
import re
import secrets
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

from g3.errors import FormatError
from g3.storage.atomic_file import flush_folder
from g3.storage.only_writer import only_writer
from g3.storage.system_errors import about


def check_target(folder: Path, *, force: bool, marker: str) -> None:
    """Refuse to write over anything but an empty folder or, if forced, one with `marker`."""
    if not folder.parent.is_dir():
        raise FormatError("there is no such folder", where=str(folder.parent), fix="make it first")
    recover(folder)
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


def write_folder(
    folder: Path, files: Mapping[str, bytes | Path], *, force: bool, marker: str
) -> None:
    """Write files into a new folder, or in place of an old one that holds `marker`.

    A file that stands for its content is copied. On the same disk it is linked, which takes no
    space. The files are written to a temporary folder beside it and flushed to the disk before
    that takes the name. At any moment the name holds the old or the new content.
    """
    folder = _absolute(folder)
    check_target(folder, force=force, marker=marker)
    new = folder.with_name(f".{folder.name}.new-{secrets.token_hex(4)}")
    with about(folder, instead_of=new), only_writer(folder):
        _tidy(folder)
        check_target(folder, force=force, marker=marker)  # what another has written meanwhile
        try:
            new.mkdir()
            for name, content in files.items():
                _write_file(new / name, content)
            flush_folder(new)
            _put(new, folder)
            flush_folder(folder.parent)
        finally:
            shutil.rmtree(new, ignore_errors=True)


def _absolute(folder: Path) -> Path:
    return Path(os.path.abspath(folder))  # noqa: PTH100 (resolve() would follow a symlink)


def _put(new: Path, folder: Path) -> None:
    """Give a folder its name, and remove an earlier one of that name."""
    if folder.exists() and exchange(new, folder):
        return  # `new` is the old one now
    old = folder.with_name(new.name.replace(".new-", ".old-"))
    try:
        if folder.exists():
            folder.rename(old)
        new.rename(folder)
    finally:
        if old.exists() and not folder.exists():
            old.rename(folder)
        shutil.rmtree(old, ignore_errors=True)


def recover(folder: Path) -> None:
    """Give a folder back that a program was replacing when it was killed, if there is one.

    FormatError if another program is replacing it right now.
    """
    folder = _absolute(folder)
    if not folder.exists() and _left(folder, "old"):
        with only_writer(folder):
            _tidy(folder)


def _tidy(folder: Path) -> None:
    """Restore or remove the leftovers of killed programs, while no other process writes."""
    old = _left(folder, "old")
    if old and not folder.exists():
        max(old, key=lambda path: path.stat().st_mtime).rename(folder)
    for path in (*_left(folder, "old"), *_left(folder, "new")):
        shutil.rmtree(path, ignore_errors=True)


def _left(folder: Path, kind: str) -> list[Path]:
    form = re.compile(rf"\.{re.escape(folder.name)}\.{kind}-[0-9a-f]{{8}}")
    if not folder.parent.is_dir():
        return []
    return [path for path in folder.parent.iterdir() if form.fullmatch(path.name) and path.is_dir()]


def link_or_copy(source: Path, target: Path) -> None:
    """Give a file a second name, or copy it where that can't be done."""
    source = source.resolve()
    try:
        os.link(source, target)
    except OSError:  # another disk, or a file system without links
        shutil.copyfile(source, target)


def _write_file(path: Path, content: bytes | Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    if isinstance(content, Path):
        link_or_copy(content, path)
        return
    with about(path), path.open("xb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


_AT_FDCWD = -100
_RENAME_EXCHANGE = 2
_CANNOT = frozenset({errno.ENOSYS, errno.EINVAL, errno.ENOTSUP, errno.EPERM})


def exchange(one: Path, other: Path) -> bool:
    """Exchange the names of two files or folders: at no moment is either name empty.

    False if the system or the file system can't, and nothing has happened. OSError if one of them
    isn't there, or may not be renamed.
    """
    rename = _renameat2()
    if rename is None:
        return False
    if rename(_AT_FDCWD, os.fsencode(one), _AT_FDCWD, os.fsencode(other), _RENAME_EXCHANGE) == 0:
        return True
    number = ctypes.get_errno()
    if number in _CANNOT:
        return False
    raise OSError(number, os.strerror(number), str(one), None, str(other))


@functools.cache
def _renameat2() -> Callable[[int, bytes, int, bytes, int], int] | None:
    """Linux's system call, where the C library has it."""
    try:
        function = ctypes.CDLL(None, use_errno=True).renameat2
    except (AttributeError, OSError, TypeError):
        return None
    path, number = ctypes.c_char_p, ctypes.c_int
    function.argtypes = [number, path, number, path, ctypes.c_uint]
    function.restype = number
    return function
