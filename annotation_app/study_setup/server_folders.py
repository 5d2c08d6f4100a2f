"""Contents of the folder of studies, for choosing in the browser and for adding to it."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from annotation_app.study_setup.own_videos import SUFFIXES
from annotation_app.study_setup.rendered_study import FILES
from corpus_tools.tables.table_reading import TABLES
from corpus_tools.video.frame_reading import to_mp4
from g3.errors import FormatError
from g3.storage import regular_file

DEEPEST = 3
"""Largest depth of nested folders that are searched."""
MOST_FOLDERS = 2000
HEAD_BYTES = 4096
UPLOADED = (*SUFFIXES, *TABLES, ".json", ".jpg", ".jpeg", ".png")
"""The endings of files that people may add."""
LARGEST_FILE = 2**30
LARGEST_FOLDER = 20 * 2**30
MOST_FILES = 5000
SPARE = 2**30
"""Bytes that stay free on the disk."""
PART = ".part"
_FILE_NAME = re.compile(r"[\w-][\w .()-]{0,150}")


@dataclass(frozen=True, slots=True)
class VideoChoice:
    """A folder or a table of videos: its path from the folder of studies, and what people read."""

    path: str
    label: str


def video_choices(root: Path) -> list[VideoChoice]:
    """Return the folders and tables of videos in a folder of studies."""
    found = []
    for folder, files in _folders(root):
        path = folder.relative_to(root).as_posix()
        own = sum(Path(name).suffix.lower() in SUFFIXES for name in files)
        rendered = sum(file.is_file() for file in folder.glob(f"*/{FILES['manifest']}"))
        if rendered and not own:
            found.append(VideoChoice(path, f"{_count(rendered)} of ct render-videos"))
        elif own and FILES["manifest"] not in files:
            found.append(VideoChoice(path, _count(own)))
        found += (
            VideoChoice(f"{path}/{name}".removeprefix("./"), "table of videos")
            for name in tables(folder, files, "video")
        )
    return found


def command_tables(root: Path) -> list[str]:
    """Return the tables of commands in a folder of studies."""
    return [
        (folder / name).relative_to(root).as_posix()
        for folder, files in _folders(root)
        for name in tables(folder, files, "command")
    ]


def files_ending(root: Path, suffix: str) -> list[str]:
    """Return the files in a folder of studies whose names have a suffix."""
    return [
        (folder / name).relative_to(root).as_posix()
        for folder, files in _folders(root)
        for name in files
        if name.lower().endswith(suffix)
    ]


def tables(folder: Path, files: list[str], column: str) -> Iterator[str]:
    """Yield the tables among a folder's files that seem to have a column."""
    for name in files:
        if Path(name).suffix.lower() in TABLES:
            try:
                with regular_file.opened(folder / name) as file:
                    head = file.read(HEAD_BYTES).split(b"\n")[0]
            except OSError:
                continue
            if column in re.split(r'[",;|:\s{\ufeff]+', head.decode("utf-8", "replace")):
                yield name


def inside(root: Path, path: str | Path) -> Path:
    """Return a path in the folder of studies; raise if it leads out of the folder."""
    found = (root / path).resolve()
    if not found.is_relative_to(root.resolve()):
        raise FormatError(
            "this is not in the folder of studies",
            where=str(path),
            fix="choose one of the list, or put it there",
        )
    return found


def add_part(folder: Path, name: str, offset: int, content: bytes, size: int) -> Path | None:
    """Add the next part of a file that comes in parts; return the file once it is whole.

    `offset` is the number of earlier bytes: at 0 the file begins again. The whole file has `size`
    bytes. A FormatError gives the reason why the file may not be added, or reports a part out of
    order.
    """
    _check_name(folder, name)
    if not 0 < size <= LARGEST_FILE or offset + len(content) > size:
        most = f"{LARGEST_FILE // 2**30} GiB"
        raise FormatError(f"a file may have 1 byte to {most}", where=name, fix="make it shorter")
    folder.mkdir(parents=True, exist_ok=True)
    part = folder / f".{name}{PART}"
    if offset == 0:
        _check_room(folder, name, size)
        part.write_bytes(b"")
    if not part.is_file() or part.stat().st_size != offset:
        raise FormatError("a part of this file is missing", where=name, fix="add it again")
    with part.open("ab") as file:
        file.write(content)
    if offset + len(content) < size:
        return None
    part.replace(folder / name)
    return folder / name


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
    if (folder / name).exists():
        raise FormatError(
            "a file of this name is there already", where=name, fix="rename yours, or leave it"
        )


def _check_room(folder: Path, name: str, size: int) -> None:
    there = [file.stat().st_size for file in folder.iterdir() if file.is_file()]
    if len(there) >= MOST_FILES or sum(there) + size > LARGEST_FOLDER:
        most = f"{MOST_FILES} files of {LARGEST_FOLDER // 2**30} GiB together"
        raise FormatError(f"a study's folder may have {most}", where=name, fix="use fewer videos")
    if shutil.disk_usage(folder).free < size + SPARE:
        raise FormatError("the server's disk is full", where=name, fix="ask for room there")


def _folders(root: Path) -> Iterator[tuple[Path, list[str]]]:
    """Yield the folder and those below it, down to `DEEPEST`, but no hidden ones, with files."""
    for number, (path, folders, files) in enumerate(os.walk(root)):
        if number >= MOST_FOLDERS:
            return
        folder = Path(path)
        depth = len(folder.relative_to(root).parts)
        folders[:] = sorted(f for f in folders if not f.startswith(".")) if depth < DEEPEST else []
        yield folder, sorted(name for name in files if not name.startswith("."))


def _count(videos: int) -> str:
    return f"{videos} video{'' if videos == 1 else 's'}"
