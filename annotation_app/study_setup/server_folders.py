"""Contents of the folder of studies, for choosing in the browser."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from annotation_app.study_setup.own_videos import SUFFIXES
from annotation_app.study_setup.rendered_study import FILES
from corpus_tools.tables.table_reading import TABLES
from g3.errors import FormatError
from g3.storage import regular_file

DEEPEST = 3
"""Largest depth of nested folders that are searched."""
MOST_FOLDERS = 2000
HEAD_BYTES = 4096


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
