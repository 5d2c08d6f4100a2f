"""Writing a file so that its name holds the old or the new content, never a part."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from g3.errors import FormatError
from g3.storage.system_errors import about


def write_bytes(path: Path, content: bytes, *, private: bool = False) -> None:
    """Write a file under a temporary name, flush it to the disk, then give it its name.

    Content that is there is replaced; of a symbolic link, the file that it points to. A file that
    isn't regular, such as ``/dev/stdout``, is written to directly.

    Parameters
    ----------
    private
        True if only its owner may read it. It never has other rights, not even while it is written.
    """
    with replacing(path, private=private) as file:
        file.write(content)


@contextmanager
def replacing(path: Path, *, private: bool = False) -> Iterator[BinaryIO]:
    """Open a file that takes its name at the end, for content too large for memory.

    An exception leaves the name what it had, and an error of the machine names it. See
    :func:`write_bytes`.
    """
    if path.exists() and not path.is_file():
        with about(path), path.open("wb") as file:
            yield file
        return
    named, path = path, path.resolve()
    temporary = path.with_name(f".{short_name(path.name)}.new-{secrets.token_hex(4)}")
    with about(named, instead_of=temporary):
        try:
            new = open(temporary, "xb", opener=_for_owner if private else None)  # noqa: SIM115
        except FileNotFoundError:
            raise FormatError(
                "there is no such folder", where=str(path.parent), fix="make it first"
            ) from None
        try:
            with new as file:
                yield file
                file.flush()
                os.fsync(file.fileno())
            temporary.replace(path)
            flush_folder(path.parent)
        finally:
            temporary.unlink(missing_ok=True)


def short_name(name: str) -> str:
    """Shorten a name so that a longer one, made of it, isn't too long for a file system."""
    return os.fsdecode(os.fsencode(name)[:200])


def flush_folder(folder: Path) -> None:
    """Bring a folder's names to the disk, so that a power cut doesn't take them back."""
    if os.name == "nt":  # where folders can't be opened
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _for_owner(path: str, flags: int) -> int:
    return os.open(path, flags, 0o600)
