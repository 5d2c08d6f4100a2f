"""Reading regular files only: pipes wait for ever, and devices never end.

Files of other people may be links to anything. A file is opened without waiting, then looked at,
and read only if it is a regular one that isn't too large.
"""

from __future__ import annotations

import bz2
import errno
import gzip
import io
import os
import stat
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, BinaryIO, TextIO

from g3.storage.system_errors import about

MOST_BYTES = 1 << 30
"""Largest file that is read into memory by default, in bytes."""
_KINDS = {
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


def opened(path: Path) -> BinaryIO:
    """Open a regular file for reading.

    Raises
    ------
    OSError
        If it can't be opened, or isn't a regular file. Its text says which.
    """
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    descriptor = os.open(path, flags | getattr(os, "O_CLOEXEC", 0))
    try:
        mode = os.fstat(descriptor).st_mode
        if stat.S_ISDIR(mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        if not stat.S_ISREG(mode):
            kind = _KINDS.get(stat.S_IFMT(mode), "of another kind")
            raise OSError(errno.ENXIO, f"this is {kind}, not a regular file", str(path))
        return os.fdopen(descriptor, "rb")
    except BaseException:
        os.close(descriptor)
        raise


@contextmanager
def text_of(path: Path) -> Iterator[TextIO]:
    """Open the text of a regular file, line by line; .gz and .bz2 are uncompressed.

    Bytes that aren't UTF-8 are replaced. Lines end at line feeds.
    """
    with opened(path) as file, ExitStack() as stack:
        plain: Any = file
        if path.suffix == ".gz":
            plain = stack.enter_context(gzip.GzipFile(fileobj=file, mode="rb"))
        elif path.suffix == ".bz2":
            plain = stack.enter_context(bz2.BZ2File(file))
        yield stack.enter_context(
            io.TextIOWrapper(plain, encoding="utf-8", errors="replace", newline="\n")
        )


def read_bytes(path: Path, *, most: int = MOST_BYTES) -> bytes:
    """Return the content of a regular file.

    Parameters
    ----------
    most
        Largest number of bytes that it may have.

    Raises
    ------
    OSError
        If it can't be read, isn't a regular file, or has more bytes.
    """
    with about(path), opened(path) as file:
        size = os.fstat(file.fileno()).st_size
        content = b"" if size > most else file.read(most + 1)
        if max(size, len(content)) > most:
            what = f"the file has {max(size, len(content))} bytes, and at most {most} are read"
            raise OSError(errno.EFBIG, what, str(path))
    return content
