"""Files that people add to a study's folder: they come in parts, and are replaced and deleted."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Literal, TypeAlias

from annotation_app.study_setup.coco_things import is_coco
from annotation_app.study_setup.own_videos import END, START, SUFFIXES
from annotation_app.study_setup.server_folders import tables
from corpus_tools.tables.table_reading import TABLES
from corpus_tools.video.frame_reading import to_mp4
from g3.errors import FormatError

Use: TypeAlias = Literal["videos", "commands", "things"]
"""Field of the study's file that names an added file."""

PICTURES = (".jpg", ".jpeg", ".png")
UPLOADED = (*SUFFIXES, *TABLES, ".json", *PICTURES)
"""The endings of files that people may add."""
LARGEST_FILE = 2**30
LARGEST_FOLDER = 20 * 2**30
MOST_FILES = 5000
SPARE = 2**30
"""Bytes that stay free on the disk."""
PARTS = ".parts"
"""Folder, in that of the files, of those that are still coming."""
_FILE_NAME = re.compile(r"[\w-][\w .()-]{0,150}")


class ThereAlreadyError(FormatError):
    """A file whose name another one has."""


def uploads(folder: Path) -> list[Path]:
    """Return the added files of a study, in the order of their names."""
    if not folder.is_dir():
        return []
    return sorted(file for file in folder.iterdir() if upload(folder, file.name))


def upload(folder: Path, name: str) -> Path | None:
    """Return an added file by its name; None if there is none."""
    file = folder / name
    is_one = _FILE_NAME.fullmatch(name) and file.is_file() and not file.is_symlink()
    return file if is_one else None


def uses(file: Path) -> list[Use]:
    """Return the uses that an added file may have, the likeliest first."""
    if file.suffix.lower() == ".json":
        return ["things"] if is_coco(file) else []
    if file.suffix.lower() not in TABLES or not _has(file, "video"):
        return []
    if not _has(file, "command"):
        return ["videos"]
    is_of_parts = _has(file, START) and _has(file, END)
    return ["videos", "commands"] if is_of_parts else ["commands", "videos"]


def add_part(
    folder: Path,
    name: str,
    offset: int,
    content: bytes,
    size: int,
    *,
    check: Callable[[Path], None],
    replacing: bool = False,
) -> Path | None:
    """Add the next part of a file that comes in parts; return the file once it is whole.

    Parameters
    ----------
    offset
        The number of earlier bytes: at 0 the file begins again.
    size
        Bytes of the whole file.
    check
        Raises a CorpusError if the whole file can't be used: then all stays as it was.
    replacing
        True if it takes the place of a file of its name.

    Raises
    ------
    FormatError
        If the file may not be added, or a part is out of order; a :class:`ThereAlreadyError` if it
        would replace another.
    """
    _check_name(folder, name)
    if (folder / name).exists() and not replacing:
        raise ThereAlreadyError(
            "a file of this name is there already", where=name, fix="replace it, or rename yours"
        )
    if not 0 < size <= LARGEST_FILE or offset + len(content) > size:
        most = f"{LARGEST_FILE // 2**30} GiB"
        raise FormatError(f"a file may have 1 byte to {most}", where=name, fix="make it shorter")
    part = folder / PARTS / name
    part.parent.mkdir(parents=True, exist_ok=True)
    if offset == 0:
        _check_room(folder, name, size)
        part.write_bytes(b"")
    if not part.is_file() or part.stat().st_size != offset:
        raise FormatError("a part of this file is missing", where=name, fix="add it again")
    with part.open("ab") as file:
        file.write(content)
    if offset + len(content) < size:
        return None
    try:
        check(part)
    except FormatError:
        part.unlink()
        raise
    part.replace(folder / name)
    return folder / name


def _has(file: Path, column: str) -> bool:
    return file.name in tables(file.parent, [file.name], column)


def _check_name(folder: Path, name: str) -> None:
    ending = Path(name).suffix.lower()
    if _FILE_NAME.fullmatch(name) and ending not in UPLOADED:
        raise FormatError(
            f"files that end in {ending or 'nothing'} can't be added",
            where=name,
            fix=f"add {', '.join(UPLOADED)}; you get an mp4 of a video by "
            f"{to_mp4(Path(name), Path(name).stem)}",
        )
    if not _FILE_NAME.fullmatch(name):
        raise FormatError(
            "a file of this name can't be added",
            where=name[:100],
            fix="use letters, digits, -, _ and . in its name",
        )


def _check_room(folder: Path, name: str, size: int) -> None:
    there = [file.stat().st_size for file in folder.iterdir() if file.is_file()]
    if len(there) >= MOST_FILES or sum(there) + size > LARGEST_FOLDER:
        most = f"{MOST_FILES} files of {LARGEST_FOLDER // 2**30} GiB together"
        raise FormatError(f"a study's folder may have {most}", where=name, fix="use fewer videos")
    if shutil.disk_usage(folder).free < size + SPARE:
        raise FormatError("the server's disk is full", where=name, fix="ask for room there")
