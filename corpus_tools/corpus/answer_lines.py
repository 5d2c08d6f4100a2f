"""Files of records by the line, which other programs fill in: read with the numbers of lines."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TypeVar

import msgspec

from g3.errors import FormatError
from g3.storage.atomic_file import replacing

Record = TypeVar("Record", bound=msgspec.Struct)


def read_lines(path: Path, kind: type[Record], *, fix: str) -> list[tuple[int, Record]]:
    """Read records, each with the number of its line; empty lines are left out.

    `fix` says what to do where a line can't be read. A file or a line that can't is a FormatError.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise FormatError(
            f"the file can't be read: {error.strerror}", where=str(path), fix="give another file"
        ) from error
    decoder = msgspec.json.Decoder(kind)
    found = []
    for number, line in enumerate(content.splitlines(), start=1):
        if not line.strip():
            continue
        try:
            found.append((number, decoder.decode(line)))
        except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError) as error:
            raise FormatError(str(error), where=f"{path}:{number}", fix=fix) from error
    return found


def write_lines(path: Path, records: Iterable[msgspec.Struct]) -> int:
    """Write records, one a line, and return how many there are."""
    encoder, count = msgspec.json.Encoder(), 0
    with replacing(path) as file:
        for record in records:
            file.write(encoder.encode(record) + b"\n")
            count += 1
    return count
