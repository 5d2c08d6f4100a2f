"""Videos from elsewhere: a folder of files, or a table that names them, and commands for them."""

from __future__ import annotations

import csv
import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from annotation_app.items.clips import CLIP, PLAYED, Look, digest_of_part, look_at, to_mp4
from annotation_app.items.media import digest
from annotation_app.study_setup.coco_things import PictureThings
from annotation_app.study_setup.every_problem import together
from g3.errors import CorpusError, FormatError
from g3.storage import regular_file
from g3.storage.atomic_file import write_bytes

SUFFIXES = (".mp4", ".webm")
TABLES = (".csv", ".jsonl")
START, END = "start_s", "end_s"
"""The columns of a part of a file."""
LONGEST_ID = 200


@dataclass(frozen=True, slots=True)
class OwnVideo:
    """A video from elsewhere."""

    video: str
    """Its name in the study: the table's ``id``, else the file's name without its ending."""
    file: Path
    """Where it is."""
    metadata: Mapping[str, Any]
    """What else the table says of it; exports have it too."""
    things: PictureThings | None = None
    """What is where in its picture, if that is known."""
    part: tuple[float, float] | None = None
    """Its beginning and its end in the file, in seconds; None if it is the whole file."""


@dataclass(frozen=True, slots=True)
class GivenCommand:
    """What somebody said for one of the study's videos, and what else a table says of it."""

    text: str
    video: str
    metadata: Mapping[str, Any]


def is_own(path: Path) -> bool:
    """Whether a path is a table, or a folder with videos from elsewhere."""
    return path.suffix.lower() in TABLES or (path.is_dir() and bool(_files(path)))


def own_videos(path: Path) -> list[OwnVideo]:
    """The videos of a folder or a table.

    A CorpusError lists all files that aren't there, and all videos that share a name.
    """
    if path.is_dir():
        found = [(str(path), OwnVideo(file.stem, file.resolve(), {})) for file in _files(path)]
    else:
        found = [(where, _video(path, row)) for where, row in _rows(path, ("video",))]
    videos: dict[str, OwnVideo] = {}
    errors: list[CorpusError] = []
    for where, item in found:
        known = videos.setdefault(item.video, item)
        if (known.file, known.part) != (item.file, item.part):
            fix = "rename one of the files" if path.is_dir() else "give each an id of its own"
            both = f"{known.file.name} and {item.file.name}"
            what = f"two {'parts' if item.part else 'files'} are called {item.video!r}: {both}"
            errors.append(FormatError(what, where=where, fix=fix))
        elif known is item and not item.file.is_file():
            fix = "correct the path, which begins at the table's folder"
            errors.append(FormatError(f"there is no file {item.file}", where=where, fix=fix))
        elif item.file.suffix.lower() not in SUFFIXES:
            what = f"{item.file.name} is no {' or '.join(s[1:] for s in SUFFIXES)} file"
            errors.append(FormatError(what, where=where, fix=f"convert it: {to_mp4(item.file)}"))
    if not errors and not videos:
        errors.append(FormatError("there are no videos", where=str(path), fix="add rows"))
    if errors:
        raise together(errors)
    return list(videos.values())


def given_commands(path: Path, videos: Sequence[OwnVideo | str]) -> list[GivenCommand]:
    """The commands of a table, whose column ``video`` has names or files of the study's `videos`.

    Of videos of ``ct render-videos`` these are the names. Rows without a command are left out: a
    table of videos may be one of commands, too. A CorpusError lists all rows that name no video.
    """
    names = {item if isinstance(item, str) else item.video for item in videos}
    whole = [item for item in videos if not isinstance(item, str) and item.part is None]
    files = {item.file: item.video for item in whole}
    commands, errors = [], []
    for where, row in _rows(path, ("video", "command")):
        text, named = " ".join(str(row["command"]).split()), str(row["video"])
        video = named if named in names else str(row.get("id", ""))
        if video not in names:
            video = files.get((path.parent / named).resolve(), "")
        if not text:
            continue
        if not video:
            fix = f"the videos are: {', '.join(sorted(names)[:20])}"
            errors.append(FormatError(f"the study has no video {named!r}", where=where, fix=fix))
        commands.append(GivenCommand(text, video, _others(row, _NOT_OTHERS)))
    if errors:
        raise together(errors)
    return commands


def has_commands(table: Path) -> bool:
    """Whether a table names commands, too."""
    return any(row.get("command") for _, row in _rows(table, ("video",)))


def check_readable(videos: Sequence[OwnVideo]) -> None:
    """Check that browsers can play videos; a CorpusError lists all that they can't."""
    errors: list[CorpusError] = []
    # Many episodes may be in a file, which is looked at once; things may be told of each.
    of_files = {item.file: item for item in reversed(videos)}
    for item in [v for v in videos if v.things is not None or of_files[v.file] is v]:
        try:
            look = _look_at(item.file, item.part[0] if item.part else 0.0)
            if item.things is not None:
                fitting_picture(item, look.picture)
        except CorpusError as error:
            errors.append(error)
    if errors:
        raise together(errors)


def prepare(item: OwnVideo, base: Path) -> Path:
    """The folder in `base` with a video's manifest and poster, made if it isn't there.

    A FormatError says that the video can't be read.
    """
    folder = base / hashlib.sha256(item.video.encode()).hexdigest()[:20]
    manifest, poster = folder / "manifest.json", folder / "poster.png"
    sha256, (start_s, end_s) = digest(item.file), item.part or (0.0, None)
    told = {"id": item.video, "has_scene": False, "steps": [], "metadata": dict(item.metadata)}
    if item.things is not None:
        told["things"] = _things_key(item.things)
    if end_s is not None:
        told["part"] = {"file": str(item.file), START: start_s, END: end_s}
        sha256 = digest_of_part(sha256, start_s, end_s)
    if manifest.is_file() and poster.is_file():
        known = msgspec.json.decode(manifest.read_bytes())
        measured = {name: known.get(name) for name in ("duration_s", "fps")}
        if known == {**told, "sha256": sha256, **measured}:
            return folder
    look = _look_at(item.file, start_s, end_s)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / CLIP).unlink(missing_ok=True)  # it may be another part
    picture = look.picture
    if item.things is not None:
        picture = fitting_picture(item, picture)
        write_bytes(folder / "segmentation.json", _outlines(item.things))
    write_bytes(poster, picture)
    made = {**told, "sha256": sha256, "duration_s": look.duration_s, "fps": look.fps}
    write_bytes(manifest, msgspec.json.encode(made))
    return folder


def fitting_picture(item: OwnVideo, first_frame: bytes) -> bytes:
    """The picture, as PNG, that a video's things are outlined in.

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


def _outlines(things: PictureThings) -> bytes:
    numbered = enumerate(things.things, start=1)
    objects = [{**thing, "value": number} for number, thing in numbered]
    content = {"width": things.width, "height": things.height, "objects": objects}
    return msgspec.json.encode(content)


def _things_key(things: PictureThings) -> str:
    """What changes with the things and their picture."""
    picture = digest(things.picture) if things.picture is not None else ""
    return hashlib.sha256(_outlines(things) + picture.encode()).hexdigest()


def played_file(item: OwnVideo, folder: Path) -> Path:
    """The file that people watch: the video, or a part, cut in the folder of :func:`prepare`."""
    return item.file if item.part is None else folder / CLIP


def _files(folder: Path) -> list[Path]:
    return sorted(f for f in folder.iterdir() if f.suffix.lower() in SUFFIXES and f.is_file())


def _video(table: Path, row: Mapping[str, Any]) -> OwnVideo:
    file = (table.parent / str(row["video"])).resolve()
    name = str(row.get("id") or file.stem)[:LONGEST_ID]
    return OwnVideo(name, file, _others(row, (*_NOT_OTHERS, "subject")), part=_part(table, row))


_NOT_OTHERS = ("id", "video", "command", START, END)


def _part(table: Path, row: Mapping[str, Any]) -> tuple[float, float] | None:
    """The part of a file that a row names; an empty cell is none."""
    told = [row.get(START, ""), row.get(END, "")]
    if told == ["", ""]:
        return None
    try:
        start_s, end_s = (float(value) for value in told)
        if not 0 <= start_s < end_s < float("inf"):
            raise ValueError
    except ValueError:
        raise FormatError(
            f"{told[0]!r} to {told[1]!r} is no part of a video",
            where=str(table),
            fix=f"give {START} and {END} in seconds, the first before the second",
        ) from None
    return start_s, end_s


def _look_at(file: Path, start_s: float, end_s: float | None = None) -> Look:
    """What a video looks like, if browsers play it."""
    look = look_at(file, start_s, end_s)
    if look.codec not in PLAYED:
        raise FormatError(
            f"browsers don't play videos of the kind {look.codec!r}",
            where=str(file),
            fix=f"convert it: {to_mp4(file)}",
        )
    return look


def _others(row: Mapping[str, Any], known: Sequence[str]) -> dict[str, Any]:
    return {name: value for name, value in row.items() if name not in known and value != ""}


def _rows(path: Path, needed: Sequence[str]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """The rows of a table, each with the place that errors name."""
    try:
        text = regular_file.read_bytes(path).decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise FormatError(
            f"the table can't be read: {error}", where=str(path), fix="save it as UTF-8 text"
        ) from error
    read = _csv_rows if path.suffix.lower() == ".csv" else _jsonl_rows
    for line, row in read(text, path):
        where = f"{path}:{line}"
        missing = [name for name in needed if name not in row]
        if missing:
            columns = ", ".join(needed)
            raise FormatError(
                f"there is no {missing[0]!r}", where=where, fix=f"the columns are {columns}"
            )
        yield where, row


def _csv_rows(text: str, path: Path) -> Iterator[tuple[int, Mapping[str, Any]]]:
    reader = csv.DictReader(text.splitlines(keepends=True))
    for row in reader:
        if None in row or None in row.values():
            raise FormatError(
                "this row has more or fewer cells than the first",
                where=f"{path}:{reader.line_num}",
                fix="put cells with commas between quotation marks",
            )
        yield reader.line_num, row


def _jsonl_rows(text: str, path: Path) -> Iterator[tuple[int, Mapping[str, Any]]]:
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip():
            continue
        try:
            yield number, msgspec.json.decode(line, type=dict[str, str | int | float | bool])
        except msgspec.DecodeError as error:
            raise FormatError(
                f"this is no object of texts and numbers: {error}",
                where=f"{path}:{number}",
                fix='write it as {"video": "clip.mp4", "command": "Go."}',
            ) from error
