"""Writing a file so that its name holds the old or the new content, never a part."""

from __future__ import annotations

import os
import secrets
from pathlib import Path

from g3.errors import FormatError


def write_bytes(path: Path, content: bytes, *, private: bool = False) -> None:
    """Write a file under a temporary name, flush it to the disk, then give it its name.

    A symbolic link stays one: the file that it points to is replaced. What is no
    regular file, such as ``/dev/stdout``, is written to directly.

    Parameters
    ----------
    path
        Where the file shall be; what is there is replaced.
    content
        All of it.
    private
        Whether only its owner may read it. It never has other rights, not even while
        it is written.

    Raises
    ------
    FormatError
        If the folder doesn't exist.
    """
    path = path.resolve()
    if path.exists() and not path.is_file():
        path.write_bytes(content)
        return
    temporary = path.with_name(f".{path.name[:200]}.new-{secrets.token_hex(4)}")
    try:
        with open(temporary, "xb", opener=_for_owner if private else None) as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    except FileNotFoundError:
        raise FormatError(
            "there is no such folder", where=str(path.parent), fix="make it first"
        ) from None
    finally:
        temporary.unlink(missing_ok=True)


def _for_owner(path: str, flags: int) -> int:
    return os.open(path, flags, 0o600)
