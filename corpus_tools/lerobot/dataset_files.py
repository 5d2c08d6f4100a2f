"""Files of a dataset: the names that its metadata give, and their content.

Metadata are other people's. Their patterns of file names are filled in by name, never by
``str.format``, and a name that leads out of the dataset is refused.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from corpus_tools.episodes.films import RESTORE
from corpus_tools.runtime.parquet import import_pyarrow
from g3.errors import CorpusError, FormatError

LARGEST = 2**31 - 1
"""Largest number of an episode, a file or a frame."""
AT_ONCE = 32 << 20
"""Bytes of a file that are read at once."""
_HUGGING_FACE = b"huggingface"
_FIELD = re.compile(r"\{(\w+)(?::(?:0(\d{1,2}))?d)?\}")


def filled_in(pattern: str, names: Mapping[str, int | str], *, where: str) -> str:
    """Fill names into a pattern such as ``chunk-{chunk_index:03d}/{video_key}.mp4``.

    Parameters
    ----------
    pattern
        Names in braces; a number may have a width, to which zeros fill it up.
    where
        The place of the pattern, for errors.
    """

    def value_of(match: re.Match[str]) -> str:
        name, width = match[1], int(match[2] or 0)
        value = names.get(name)
        is_number = isinstance(value, int)
        if value is None or (":" in match[0] and not is_number):
            raise _bad_pattern(pattern, names, where)
        return f"{value:0{width}d}" if is_number else str(value)

    if re.search(r"[{}]", _FIELD.sub("", pattern)):
        raise _bad_pattern(pattern, names, where)
    return _FIELD.sub(value_of, pattern)


def _bad_pattern(pattern: str, names: Mapping[str, Any], where: str) -> FormatError:
    shown = pattern if len(pattern) <= 200 else f"{pattern[:200]}…"
    return FormatError(
        f"{shown!r} is no pattern of file names",
        where=where,
        fix=f"the names are {', '.join(names)}, and numbers may have a width as in :03d",
    )


def file_inside(folder: Path, name: str, *, where: str, checked: set[Path] | None = None) -> Path:
    """Return the path of a file of a dataset; `folder` is the dataset's, resolved.

    Parameters
    ----------
    checked
        Folders of earlier calls, which are noted here: their files are only looked at themselves.

    Raises
    ------
    FormatError
        If the name or a symbolic link leads out of the dataset. Links into the ``blobs`` of
        Hugging Face's cache, in whose ``snapshots`` the dataset lies, are part of it.
    """
    pure = PurePosixPath(name)
    if not name or pure.is_absolute() or ".." in pure.parts or re.search(r"[\\\x00-\x1f]", name):
        raise _outside(name, where)
    path = folder / pure
    try:
        if checked is not None and path.parent in checked and not path.is_symlink():
            return path
        real = path.resolve()
    except (OSError, RuntimeError) as error:  # a name that is too long, or links in a circle
        raise FormatError(f"{name!r} can't be followed: {error}", where=where, fix=RESTORE) from (
            error
        )
    if folder in real.parents or (
        folder.parent.name == "snapshots" and folder.parent.parent / "blobs" in real.parents
    ):
        if checked is not None and real == path:
            checked.add(path.parent)
        return path
    raise _outside(name, where)


def _outside(name: str, where: str) -> FormatError:
    return FormatError(
        f"{name!r} leads out of the dataset",
        where=where,
        fix="all files of a dataset lie in its folder: copy this one there",
    )


def files_below(folder: Path, place: str, pattern: str = "*/*.parquet") -> list[Path]:
    """Return the files of a part of a dataset, in the order of the numbers in their names.

    Files whose names begin with a dot are other systems' and left out. The other parameters and
    errors are those of :func:`file_inside`.
    """
    files = [f for f in (folder / place).glob(pattern) if not f.name.startswith(".")]
    names = [file.relative_to(folder).as_posix() for file in files]
    return [file_inside(folder, n, where=str(folder / n)) for n in sorted(names, key=_in_order)]


def _in_order(name: str) -> tuple[tuple[int, str], ...]:
    """Return a key by which numbers in names are compared as numbers."""
    pieces = re.findall(r"\d+|\D+", name)
    return tuple((int(piece), "") if piece.isdecimal() else (-1, piece) for piece in pieces)


@contextmanager
def content_of(file: Path) -> Iterator[None]:
    """Turn any error that damaged content causes into a FormatError that names the file."""
    pa, _ = import_pyarrow()
    try:
        yield
    except CorpusError:
        raise
    except (
        pa.ArrowException, OSError, ValueError, TypeError, LookupError, ArithmeticError,
        MemoryError, RecursionError,
    ) as error:  # fmt: skip
        lines = str(error).splitlines() or [type(error).__name__]
        raise damaged(file, f"the file can't be read: {lines[0]}") from error


def damaged(where: Path | str, what: str) -> FormatError:
    """Return the error that a file of the dataset isn't as it should be."""
    return FormatError(what, where=str(where), fix=RESTORE)


def check_is_file(file: Path) -> None:
    """Raise a FormatError unless there is such a file: no folder, pipe or device."""
    if not os.path.isfile(file):  # noqa: PTH113 - Path.is_file raises for some names
        is_there = os.path.lexists(file)
        what = "this is no file" if is_there else "there is no such file"
        raise FormatError(what, where=str(file), fix="download all of the dataset")


@contextmanager
def parquet_file(file: Path) -> Iterator[Any]:
    """Open a Parquet file; a FormatError names it if it can't be read, also later on."""
    check_is_file(file)
    _, pq = import_pyarrow()
    with content_of(file), pq.ParquetFile(file) as parquet:
        yield parquet


def rows_of_size(parquet: Any, most: int) -> int:
    """Return how many rows of a file to read at once, so that memory stays flat; at most `most`."""
    groups = range(parquet.num_row_groups)
    size = sum(parquet.metadata.row_group(group).total_byte_size for group in groups)
    rows = parquet.metadata.num_rows
    return max(1, min(most, AT_ONCE * rows // size)) if size > 0 and rows > 0 else 1


def json_lines(file: Path) -> Iterator[Record]:
    """Yield the records of a file with a JSON object on each line."""
    check_is_file(file)
    with file.open("rb") as stream:
        for number, line in enumerate(stream, start=1):
            if line.strip():
                try:
                    yield Record(file, number, msgspec.json.decode(line, type=dict[str, Any]))
                except (msgspec.MsgspecError, ValueError, RecursionError) as error:
                    raise damaged(f"{file}, row {number}", f"this is no record: {error}") from error


@dataclass(frozen=True, slots=True)
class Record:
    """A row of metadata, whose values are converted to their types, or refused."""

    file: Path
    row: int
    """Counted from 1."""
    values: Mapping[str, Any]

    def whole(self, column: str) -> int:
        """Return a whole number, not negative; 3.0 is one, too."""
        value = self._number(column)
        if value != int(value) or not 0 <= value <= LARGEST:
            raise self.error(column, f"{value} is no whole number from 0 to {LARGEST}")
        return int(value)

    def seconds(self, column: str) -> float:
        """Return a time in seconds, not negative."""
        value = float(self._number(column))
        if value < 0:
            raise self.error(column, f"{value} is no time in seconds")
        return value

    def texts(self, column: str) -> tuple[str, ...]:
        """Return the texts of a list; a lone text is a list of one, and nulls are left out."""
        value = self.values.get(column)
        listed = value if isinstance(value, list | tuple) else [value]
        texts = [text for text in listed if text is not None]
        if not all(isinstance(text, str) for text in texts):
            raise self.error(column, f"{value!r:.80} is no list of texts")
        return tuple(texts)

    def _number(self, column: str) -> int | float:
        if column not in self.values:
            raise self.error(column, "there is no such column")
        value = self.values[column]
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.error(column, f"{value!r:.80} is no number")
        if not abs(value) < float("inf"):
            raise self.error(column, f"{value} is no number")
        return value

    def error(self, column: str, what: str) -> FormatError:
        """Return the error that a column's value is wrong."""
        return damaged(f"{self.file}, row {self.row}, column {column}", what)


def with_features(
    metadata: Mapping[bytes, bytes] | None, features: Mapping[str, Any]
) -> dict[bytes, bytes]:
    """Return a Parquet file's metadata with types of columns, for Hugging Face's ``datasets``."""
    before = dict(metadata or {})
    try:
        content = json.loads(before[_HUGGING_FACE])
        content["info"]["features"].update(features)
    except (KeyError, TypeError, ValueError, AttributeError):  # it isn't from there
        return before
    return before | {_HUGGING_FACE: json.dumps(content).encode()}


def is_text(kind: Any) -> bool:
    """Return True for a type of pyarrow whose values are texts."""
    pa, _ = import_pyarrow()
    kind = kind.value_type if pa.types.is_dictionary(kind) else kind
    return bool(pa.types.is_string(kind) or pa.types.is_large_string(kind))


def numbers_of(batch: Any, column: str, file: Path, first_row: int) -> npt.NDArray[np.float64]:
    """Return a column of frames as numbers, shape (n,); `first_row` is the batch's, from 0."""
    pa, _ = import_pyarrow()
    where = f"{file}, column {column}"
    if column not in batch.schema.names:
        raise damaged(where, "there is no such column")
    values = batch.column(column)
    if not (pa.types.is_integer(values.type) or pa.types.is_floating(values.type)):
        raise damaged(where, f"the type is {values.type!s:.80}, which are no numbers")
    numbers: npt.NDArray[np.float64] = values.to_numpy(zero_copy_only=False).astype(np.float64)
    bad = np.flatnonzero(~np.isfinite(numbers))
    if len(bad):
        where = f"{file}, row {first_row + int(bad[0]) + 1}, column {column}"
        raise damaged(where, f"{values[int(bad[0])].as_py()} is no number")
    return numbers


def whole_numbers_of(batch: Any, column: str, file: Path, first_row: int) -> npt.NDArray[np.int64]:
    """Return a column of whole numbers, not negative, with the parameters of :func:`numbers_of`."""
    numbers = numbers_of(batch, column, file, first_row)
    bad = np.flatnonzero((numbers != np.floor(numbers)) | (numbers < 0) | (numbers > LARGEST))
    if len(bad):
        where = f"{file}, row {first_row + int(bad[0]) + 1}, column {column}"
        raise damaged(where, f"{numbers[bad[0]]:g} is no whole number from 0 to {LARGEST}")
    return numbers.astype(np.int64)


def first_of(names: Sequence[object], most: int = 5) -> str:
    """Return some names for a message, and how many more there are."""
    shown = ", ".join(map(str, names[:most]))
    return f"{shown} and {len(names) - most} more" if len(names) > most else shown
