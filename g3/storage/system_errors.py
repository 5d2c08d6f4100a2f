"""Errors of the machine: full disks, missing rights, failing devices.

An :class:`OSError` names a file only where the system call was given a name. :func:`about` adds
the name where a file is written or read through a descriptor. :func:`named_error` makes an error
of it that also says what to do.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from g3.errors import CorpusError

_SPACE = "make room there or choose another place, then run the command again"
_RIGHTS = "get the right to use it, or choose another place"
_NAME = "correct the name"
_REGULAR = "name a regular file"
_MOUNT = "mount its folder again, or choose another place"
_FIXES = {
    "ENOSPC": _SPACE,
    "EDQUOT": _SPACE,
    "EFBIG": "raise the limit of a file's size or choose another place",
    "EROFS": "choose a place that can be written to",
    "EACCES": _RIGHTS,
    "EPERM": _RIGHTS,
    "EIO": "check the disk, or choose another place",
    "EMFILE": "let this program open more files, such as with `ulimit -n 4096`",
    "ENFILE": "end other programs",
    "ENOMEM": "end other programs, or use a machine with more memory",
    "ENAMETOOLONG": "choose a shorter name",
    "ENOENT": _NAME,
    "ENOTDIR": _NAME,
    "EISDIR": _REGULAR,
    "EEXIST": "choose another name, or remove it",
    "ENOTEMPTY": "choose another name, or empty it",
    "ELOOP": "correct the link",
    "EBUSY": "wait until the program that uses it is done",
    "ETXTBSY": "end the program first",
    "ENXIO": _REGULAR,
    "ENODEV": _REGULAR,
    "ESTALE": _MOUNT,
    "EREMOTEIO": _MOUNT,
    "ENOLCK": "choose a place on a disk of this machine",
}
"""Fixes by the system's name of the error; not all systems have all of them."""
_BY_NUMBER = {getattr(errno, name): fix for name, fix in _FIXES.items() if hasattr(errno, name)}


@contextmanager
def about(path: str | Path, *, instead_of: str | Path | None = None) -> Iterator[None]:
    """Give errors of the machine that name no file the name of this one.

    An interruption (:class:`KeyboardInterrupt`) gets it as well, as its argument.

    Parameters
    ----------
    instead_of
        A name that only this program knows, of a temporary file or folder. It is replaced, also
        in the names of files in such a folder.
    """
    try:
        yield
    except OSError as error:
        if error.errno is None:
            raise
        named = _renamed(path if error.filename is None else error.filename, instead_of, path)
        try:
            error.filename = named
        except AttributeError:  # PyAV's errors keep theirs
            raise OSError(error.errno, error.strerror, named) from error
        if error.filename2 is not None:
            error.filename2 = _renamed(error.filename2, instead_of, path)
        raise
    except KeyboardInterrupt as interruption:
        if not interruption.args:
            interruption.args = (str(path),)
        raise


def _renamed(name: Any, old: str | Path | None, new: str | Path) -> Any:
    if isinstance(name, int):  # the number of a descriptor
        return name
    text = os.fsdecode(name)
    if text == str(old):
        return str(new)
    inside = text.removeprefix(f"{old}{os.sep}")
    return text if inside == text else str(Path(new) / inside)


def named_error(error: OSError) -> CorpusError | None:
    """Return an error of the machine with the file that it is about, and how to fix it.

    Returns
    -------
    CorpusError or None
        None if it isn't about a file but, for example, about a connection.
    """
    fix = _BY_NUMBER.get(error.errno or 0)
    of_two = error.filename if error.filename2 is None else error.filename2
    if of_two is None and fix is None:
        return None
    where = _renamed("" if of_two is None else of_two, None, "")
    what = error.strerror or str(error)
    return CorpusError(what, where=str(where), fix=fix or "check the file and its disk")
