"""One writer at a time: a lock beside what is written, which ends with the program."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from g3.errors import FormatError
from g3.storage.atomic_file import short_name
from g3.storage.system_errors import about

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]


@contextlib.contextmanager
def only_writer(target: Path) -> Iterator[None]:
    """Hold the lock of a file or folder that is to be written.

    The lock is the file ``.NAME.lock`` beside it, which goes away at the end. That of a program
    that was killed holds nobody up. On file systems that have no locks there is none.

    Parameters
    ----------
    target
        The file or folder that is written; its parent must be there.

    Raises
    ------
    FormatError
        If another program holds the lock. It isn't waited for.
    """
    path = lock_of(target)
    try:
        with about(target, instead_of=path):
            descriptor = _taken(path)
    except (BlockingIOError, FileExistsError):
        raise FormatError(
            "another program is writing this",
            where=str(target),
            fix="wait until it is done, or choose another name",
        ) from None
    try:
        yield
    finally:
        if fcntl is not None:  # while it is held, so that it is nobody else's
            path.unlink(missing_ok=True)
        os.close(descriptor)


def lock_of(target: Path) -> Path:
    """Return the file that is locked during writing."""
    return target.with_name(f".{short_name(target.name)}.lock")


def _taken(path: Path) -> int:
    if fcntl is None:  # a file that is there as long as it is open
        return os.open(path, os.O_CREAT | os.O_EXCL | os.O_RDWR | os.O_TEMPORARY)  # type: ignore[attr-defined,unused-ignore]
    while True:
        descriptor = os.open(path, os.O_CREAT | os.O_RDWR, 0o600)
        try:
            with contextlib.suppress(NotImplementedError):
                _lock(descriptor)
            if _is_same(descriptor, path):
                return descriptor
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)  # whoever held it has removed it meanwhile


def _lock(descriptor: int) -> None:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise
    except OSError as error:  # the file system has no locks
        raise NotImplementedError from error


def _is_same(descriptor: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except FileNotFoundError:
        return False
