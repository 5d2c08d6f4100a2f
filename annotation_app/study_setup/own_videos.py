"""Videos from elsewhere: a folder of files, or a table that names them, and commands for them."""

from __future__ import annotations

import hashlib
import mimetypes
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import msgspec

from annotation_app.items.media import digest
from annotation_app.items.scenes import MOST_VIEWS
from annotation_app.study_setup.coco_things import PictureThings
from annotation_app.study_setup.every_problem import together
from corpus_tools.tables.curve_file import SUFFIX, read_header
from corpus_tools.tables.file_names import find_file, is_shadow, normal_name
from corpus_tools.tables.table_reading import (
    TABLES,
    OnNote,
    Row,
    lines_named,
    no_note,
    read_table,
)
from corpus_tools.video.frame_reading import to_mp4
from g3.errors import CorpusError, FormatError
from g3.storage import regular_file

SUFFIXES = (".mp4", ".webm")
START, END = "start_s", "end_s"
"""The columns of a part of a file."""
CAMERA = "camera"
CURVES, CURVES_START = "curves", "curves_start_s"
LONGEST_ID = 200
MOST_NAMED = 20
"""Largest number of files or videos named in a message."""


@dataclass(frozen=True, slots=True)
class OwnVideo:
    """A video from elsewhere."""

    video: str
    """Its name in the study: the table's ``id``, else the file's name without its ending."""
    file: Path
    """Path of the video."""
    metadata: Mapping[str, Any]
    """Other columns of the table; exports have them too."""
    things: PictureThings | None = None
    """Things in the video's picture, if they are known."""
    part: tuple[float, float] | None = None
    """Its beginning and its end, in seconds from the file's first frame; None for a whole file."""
    where: str = field(default="", compare=False)
    """The row that names it, for errors."""
    camera: str = ""
    """Name of its camera, if it is known."""
    views: tuple[OwnVideo, ...] = ()
    """The same events by further cameras, on the same clock."""
    curves: Path | None = None
    """A file of numbers over time that people see as curves beside it."""
    curves_start_s: float = 0.0
    """Time of the curves at which the video begins."""

    @property
    def other_files(self) -> list[Path]:
        """The other files that people see: those of further cameras, curves, and a picture."""
        picture = self.things.picture if self.things is not None else None
        files = (*(view.file for view in self.views), self.curves, picture)
        return [file for file in files if file is not None]


@dataclass(frozen=True, slots=True)
class GivenCommand:
    """A command given for one of the study's videos, with a table's other columns."""

    text: str
    video: str
    metadata: Mapping[str, Any]


def is_own(path: Path) -> bool:
    """Check that a path is a table, or a folder with videos from elsewhere."""
    return path.suffix.lower() in TABLES or (path.is_dir() and bool(_files(path)))


def own_videos(path: Path, on_note: OnNote = no_note) -> list[OwnVideo]:
    """Find the videos of a folder or a table.

    Parameters
    ----------
    on_note
        Takes lines about files and rows that aren't used.

    Raises
    ------
    CorpusError
        If files aren't there or videos share a name; it lists all.
    """
    of_folder = path.is_dir()
    found = _of_folder(path, on_note) if of_folder else _of_table(path, on_note)
    videos: dict[str, OwnVideo] = {}
    repeated: list[str] = []
    errors: list[CorpusError] = []
    for where, named, has_command in found:
        item = replace(named, where=where)
        first = videos.setdefault(normal_name(item.video), item)
        if (first.file, first.part) != (item.file, item.part):
            fix = "rename one of the files" if of_folder else "give each an id of its own"
            both = f"{first.file.name} and {item.file.name}"
            what = f"two {'parts' if item.part else 'files'} are called {item.video!r}: {both}"
            errors.append(FormatError(what, where=where, fix=fix))
        elif first is not item:
            repeated += [] if has_command else [where]
        else:
            errors += _wrong_files(item)
    if not errors and not videos:
        fix = "put mp4 or webm files there, or name a table of videos" if of_folder else "add rows"
        errors.append(FormatError("there are no videos", where=str(path), fix=fix))
    if errors:
        raise together(errors)
    if repeated:
        on_note(
            f"{path}: {_are(len(repeated), 'row')} of a video that is in the table already, and "
            f"not used, such as {repeated[0]}; an id of its own makes it another"
        )
    return list(videos.values())


def _wrong_files(item: OwnVideo) -> Iterator[CorpusError]:
    for one in (item, *item.views):
        if not os.path.isfile(one.file):  # noqa: PTH113 - a Path refuses names that are too long
            fix = "correct the path, which begins at the table's folder"
            what = f"there is no file {short(str(one.file))}"
            yield FormatError(what, where=item.where, fix=fix)
        elif one.file.suffix.lower() not in SUFFIXES:
            what = f"{one.file.name} is no {' or '.join(s[1:] for s in SUFFIXES)} file"
            yield FormatError(what, where=item.where, fix=f"convert it: {to_mp4(one.file)}")
    if item.curves is not None:
        try:
            read_header(item.curves)
        except FormatError as error:
            yield error


def given_commands(
    path: Path,
    videos: Sequence[OwnVideo | str],
    on_note: OnNote = no_note,
    *,
    has_videos: bool = False,
) -> list[GivenCommand]:
    """Find the commands of a table, whose column ``video`` names the study's videos.

    Parameters
    ----------
    videos
        The study's videos, those of ``ct render-videos`` by their names. A row names one by its
        name, by its ``id`` or by its file.
    on_note
        Takes lines about rows that aren't used.
    has_videos
        If the table is that of the videos, too: then rows without a command are used.

    Raises
    ------
    CorpusError
        If rows name no video of the study, or several; it lists all.
    """
    names = {normal_name(v): v for v in (v if isinstance(v, str) else v.video for v in videos)}
    files: dict[Path, list[str]] = {}
    for item in videos:
        if not isinstance(item, str) and item.part is None:
            files.setdefault(item.file, []).append(item.video)
    commands: dict[tuple[str, str], GivenCommand] = {}
    bare, repeated, errors = list[int](), list[int](), list[CorpusError]()
    for row in read_table(path, ("video", "command"), on_note):
        text = " ".join(row.text("command").split())
        if not text:
            bare.append(row.line)
            continue
        try:
            video = video_of(row, names, files)
        except CorpusError as error:
            errors.append(error)
            continue
        if (video, text) in commands:
            repeated.append(row.line)
        else:
            others = _others(row.values, _NOT_OTHERS)
            commands[video, text] = GivenCommand(text, video, others)
    if errors:
        raise together(errors)
    if bare and not has_videos:
        on_note(f"{path}: {_are(len(bare), 'row')} without a command: {lines_named(bare)}")
    if repeated:
        on_note(
            f"{path}: {_are(len(repeated), 'row')} not used, as the same video has the same "
            f"command already: {lines_named(repeated)}"
        )
    return list(commands.values())


def has_commands(table: Path) -> bool:
    """Return True if a table has commands, too."""
    return any(row.text("command").strip() for row in read_table(table, ("video",)))


def fitting_picture(item: OwnVideo, first_frame: bytes) -> bytes:
    """Return the picture, as PNG, in which a video's things are outlined.

    A FormatError if it can't be read, or isn't as large as the file of things says.
    """
    import cv2  # noqa: PLC0415 - large, and not always installed

    from corpus_tools.video.picture_file import decoded  # noqa: PLC0415 - as above

    assert item.things is not None  # noqa: S101 - only then it is asked for
    of, wanted = item.things.picture or item.file, (item.things.width, item.things.height)
    content = regular_file.read_bytes(item.things.picture) if item.things.picture else first_frame
    found = decoded(content, where=str(of))
    size = found.shape[1], found.shape[0]
    if size != wanted:
        raise FormatError(
            f"the picture has {size[0]} by {size[1]} pixels, and the things were marked in one of "
            f"{wanted[0]} by {wanted[1]}",
            where=str(of),
            fix="correct width and height of the image in the COCO file, or use the picture there",
        )
    is_written, png = cv2.imencode(".png", found)
    assert is_written  # noqa: S101 - any picture can be
    return png.tobytes()


def outlines_of(things: PictureThings) -> bytes:
    """Return the content of ``segmentation.json``."""
    numbered = enumerate(things.things, start=1)
    objects = [{**thing, "value": number} for number, thing in numbered]
    content = {"width": things.width, "height": things.height, "objects": objects}
    return msgspec.json.encode(content)


def things_key(things: PictureThings) -> str:
    """Return a digest of the things and their picture."""
    picture = digest(things.picture) if things.picture is not None else ""
    return hashlib.sha256(outlines_of(things) + picture.encode()).hexdigest()


def _files(folder: Path) -> list[Path]:
    return sorted(
        f
        for f in folder.iterdir()
        if f.suffix.lower() in SUFFIXES and not _is_hidden(f) and f.is_file()
    )


def _is_hidden(file: Path) -> bool:
    return file.name.startswith(".") or is_shadow(Path(file.name))


def _of_folder(folder: Path, on_note: OnNote) -> Iterator[tuple[str, OwnVideo, bool]]:
    """Yield the videos of a folder, each with its place, and False as none has a command."""
    used = _files(folder)
    others = sorted(file for file in set(folder.iterdir()) - set(used) if file.is_file())
    hidden = [file for file in others if _is_hidden(file)]
    foreign = [
        file
        for file in others
        if file not in hidden and str(mimetypes.guess_type(file.name)[0]).startswith("video/")
    ]
    deeper = [f for f in sorted(folder.glob("*/*")) if f.suffix.lower() in SUFFIXES]
    deeper = [f for f in deeper if not (_is_hidden(f) or _is_hidden(f.parent))]
    for files, what in (
        (hidden, "hidden, or another system's, and not looked at"),
        (foreign, f"no {' or '.join(s[1:] for s in SUFFIXES)}, and not used"),
        (deeper, "in folders of this folder, and not used"),
    ):
        if files:
            names = ", ".join(str(file.relative_to(folder)) for file in files[:MOST_NAMED])
            on_note(f"{folder}: {_are(len(files), 'file')} {what}: {names}")
    for file in map(absolute, used):
        curves = file.with_suffix(SUFFIX)
        beside = curves if curves.is_file() else None
        yield str(folder), OwnVideo(file.stem, file, {}, curves=beside), False


def _of_table(table: Path, on_note: OnNote) -> Iterator[tuple[str, OwnVideo, bool]]:
    """Yield the videos of a table, each with its row's place, and True if it has a command."""
    shadows = []
    for row in read_table(table, ("video",), on_note):
        where = row.where("video")
        if not row.text("video").strip():
            raise FormatError("the row names no video", where=where, fix="name its file")
        file = absolute(find_file(table.parent, row.text("video")))
        if is_shadow(Path(file.name)):
            shadows.append(row.line)
            continue
        video = row.text("id")[:LONGEST_ID] or file.stem[:LONGEST_ID]
        others = _others(row.values, (*_NOT_OTHERS, "subject"))
        camera = row.text(CAMERA)[:LONGEST_ID]
        curves, curves_start_s = _curves(row)
        item = OwnVideo(
            video,
            file,
            others,
            part=_part(row),
            camera=camera,
            views=tuple(_views(row, video)),
            curves=curves,
            curves_start_s=curves_start_s,
        )
        yield where, item, bool(row.text("command").strip())
    if shadows:
        on_note(
            f"{table}: {_are(len(shadows), 'file')} another system's and not looked at: "
            f"{lines_named(shadows)}"
        )


def _are(count: int, noun: str) -> str:
    return f"1 {noun} is" if count == 1 else f"{count} {noun}s are"


def _views(row: Row, video: str) -> Iterator[OwnVideo]:
    """Yield the further cameras' videos of a row, whose columns end in a number from 2 on."""
    for number in range(2, MOST_VIEWS + 1):
        named = row.text(f"video_{number}").strip()
        if named:
            part = _part(row, f"_{number}")
            camera = row.text(f"{CAMERA}_{number}")[:LONGEST_ID] or str(number)
            file = absolute(find_file(row.table.parent, named))
            name = f"{video}, camera {camera}"
            where = row.where(f"video_{number}")
            yield OwnVideo(name, file, {}, part=part, where=where, camera=camera)


def _curves(row: Row) -> tuple[Path | None, float]:
    """Return the file of curves of a row, and the time there at which the video begins."""
    named, start = row.text(CURVES).strip(), row.text(CURVES_START).strip() or "0"
    if not named:
        return None, 0.0
    try:
        start_s = float(start)
        if not 0 <= start_s < float("inf"):
            raise ValueError
    except ValueError:
        raise FormatError(
            f"{short(start)!r} is no time in curves",
            where=row.where(CURVES_START),
            fix=f"give {CURVES_START} in seconds",
        ) from None
    return absolute(find_file(row.table.parent, named)), start_s


_OF_VIEWS = [
    f"{name}_{number}"
    for number in range(2, MOST_VIEWS + 1)
    for name in ("video", START, END, CAMERA)
]
_NOT_OTHERS = ("id", "video", "command", START, END, CURVES, CURVES_START, *_OF_VIEWS)


def absolute(file: Path) -> Path:
    """Return an absolute path. Links keep their names: what they lead to may have no ending."""
    return Path(os.path.abspath(file))  # noqa: PTH100 - Path.resolve follows links


def _part(row: Row, ending: str = "") -> tuple[float, float] | None:
    """Return the part of a file that a row names; empty cells are none."""
    of_start, of_end = f"{START}{ending}", f"{END}{ending}"
    start, end = row.text(of_start).strip(), row.text(of_end).strip()
    if not start and not end:
        return None
    try:
        start_s, end_s = float(start), float(end)
        if not 0 <= start_s < end_s < float("inf"):
            raise ValueError
    except ValueError:
        raise FormatError(
            f"{short(start)!r} to {short(end)!r} is no part of a video",
            where=row.where(of_start if of_start in row.columns else of_end),
            fix=f"give {of_start} and {of_end} in seconds, the first before the second",
        ) from None
    return start_s, end_s


def video_of(row: Row, names: Mapping[str, str], files: Mapping[Path, Sequence[str]]) -> str:
    """Return the video of a row, by its name, its id or its file.

    Parameters
    ----------
    names
        The study's videos by their names in Unicode's normal form.
    files
        Names of the videos that show a whole file, by the file.
    """
    named = row.text("video")
    for name in map(normal_name, (named, row.text("id"))):
        if name in names:
            return names[name]
    file = absolute(find_file(row.table.parent, named))
    of_file = files.get(file, ())
    if len(of_file) == 1:
        return of_file[0]
    if of_file:
        what = f"{short(named)!r} is the file of several videos: {', '.join(of_file[:MOST_NAMED])}"
        fix = "name one of them in the column video or id"
    else:
        what = f"the study has no video {short(named)!r}"
        fix = f"the videos are: {', '.join(sorted(names.values())[:MOST_NAMED])}"
    raise FormatError(what, where=row.where("video"), fix=fix)


def short(text: str) -> str:
    """Return a text as errors show it, which may be as long as a table."""
    return text if len(text) <= LONGEST_ID else f"{text[:LONGEST_ID]}…"


def _others(row: Mapping[str, Any], known: Sequence[str]) -> dict[str, Any]:
    return {name: value for name, value in row.items() if name not in known and value != ""}
