"""Videos that are cut out of files when somebody first watches them.

Robots' datasets have many episodes one after the other in a file. A part has a folder with a
manifest, which names the file and the part, and no video. :func:`ensure` makes that. So no video is
stored twice but those that people watch, and the cut ones can be deleted at any time.

A whole file is made so, too, if browsers would show it on another clock than that of answers
and exports, without its length, or without an index (:func:`plays_alike`).
"""

from __future__ import annotations

import hashlib
import secrets
from pathlib import Path

import msgspec

from annotation_app.items.scenes import MANIFEST
from corpus_tools.video.cutting import Span, cut, span, whole
from corpus_tools.video.probe import VideoInfo, file_digest, probe
from g3.errors import FormatError

CLIP = "clip"
"""The name of a cut video without its ending, in the folder with its manifest."""
CUT_VERSION = 2
"""Raised whenever cut videos are to be cut again."""
ENDINGS = (".mp4", ".webm")
_LEAST_S = 0.25
"""By so much the length that browsers show may differ: sound often ends a little later."""


class Part(msgspec.Struct, frozen=True):
    """A part of a video file, in seconds from the file's first frame; or the whole file."""

    file: str
    start_s: float = 0.0
    end_s: float | None = None

    def digest(self, sha256: str) -> str:
        """Return what identifies the part of a file with a SHA-256 digest."""
        if self.end_s is None:
            return sha256
        return hashlib.sha256(f"{sha256} {self.start_s!r} {self.end_s!r}".encode()).hexdigest()

    def span(self, info: VideoInfo) -> Span:
        """Return the frames of the part; a FormatError if they aren't in the file."""
        return whole(info) if self.end_s is None else span(info, self.start_s, self.end_s)


class _Manifest(msgspec.Struct, frozen=True):
    sha256: str
    part: Part


def plays_alike(file: Path, info: VideoInfo) -> bool:
    """Return True if browsers show a file from 0 on, with its length, as they show a cut one."""
    frame_s = 1 / info.fps
    return (
        file.suffix.lower() == f".{info.container}"
        and abs(info.first_time_s) < frame_s / 2
        and info.stated_s > 0
        and abs(info.stated_s - info.duration_s) < max(2 * frame_s, _LEAST_S)
    )


def clip_path(folder: Path, info: VideoInfo) -> Path:
    """Return where the cut video of a folder is, or will be."""
    return folder / f"{CLIP}.{info.container}"


def is_clip(path: Path) -> bool:
    """Return True if a file is cut out of another one, or will be."""
    return _manifest(path) is not None


def clip_digest(path: Path) -> str | None:
    """Return what identifies a clip, which is known before it is cut; None for other files."""
    manifest = _manifest(path)
    return None if manifest is None else manifest.sha256


def source_problem(path: Path, sha256: str) -> str:
    """Return the fault of the file that a video is in; empty if it is unchanged.

    Parameters
    ----------
    path
        The video, which may be a clip.
    sha256
        Its digest when people were first asked about it.
    """
    part = _part(path)
    try:
        found = part.digest(file_digest(Path(part.file)))
    except FormatError as error:
        return f"{part.file}: {error.what}"
    return "" if found == sha256 else f"{part.file} has been replaced or changed"


def source_file(path: Path) -> Path:
    """Return the file that a video is in, which may be a clip."""
    return Path(_part(path).file)


def ensure(path: Path) -> None:
    """Cut a clip if it isn't there.

    Several servers may do that at once: each writes a file of its own, the last one stays.

    Raises
    ------
    FormatError
        If its video can't be read, or isn't the video that people were asked about.
    """
    manifest = None if path.is_file() else _manifest(path)
    if manifest is None:
        return
    part, file = manifest.part, Path(manifest.part.file)
    info = probe(file)
    if part.digest(info.sha256) != manifest.sha256:
        raise FormatError(
            "the video has been replaced or changed since it was asked about",
            where=str(file),
            fix="put the old file back, or give the new one an id of its own",
        )
    new = path.with_name(f".{path.stem}-{secrets.token_hex(4)}{path.suffix}")
    try:
        cut(file, info, part.span(info), new)
        new.replace(path)
    finally:
        new.unlink(missing_ok=True)


def _part(path: Path) -> Part:
    manifest = _manifest(path)
    return Part(str(path)) if manifest is None else manifest.part


def _manifest(path: Path) -> _Manifest | None:
    """Return the manifest that describes how to cut a clip; None for other files."""
    if path.stem != CLIP or path.suffix not in ENDINGS:
        return None
    try:
        return msgspec.json.decode(path.with_name(MANIFEST).read_bytes(), type=_Manifest)
    except (OSError, msgspec.DecodeError):
        return None
