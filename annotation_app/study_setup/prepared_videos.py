"""Videos from elsewhere made ready for people: looked at, with a manifest and a poster."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from annotation_app.items.clips import CLIP, CUT_VERSION, Part, clip_path, is_clip, plays_alike
from annotation_app.items.scenes import MANIFEST, Beside, read_film
from annotation_app.study_setup.every_problem import together
from annotation_app.study_setup.own_videos import (
    SUFFIXES,
    OwnVideo,
    fitting_picture,
    outlines_of,
    things_key,
)
from corpus_tools.runtime.progress import OnProgress, no_progress
from corpus_tools.video.cutting import constant_rate, cut, first_picture
from corpus_tools.video.frame_reading import has_decoder, to_mp4
from corpus_tools.video.probe import VideoInfo, probe
from g3.errors import CorpusError, FormatError
from g3.storage import regular_file
from g3.storage.atomic_file import write_bytes
from g3.storage.cache_folder import cache_folder

THUMBNAIL_PX = 240
"""Width of a thumbnail."""
POSTER, FILM = "poster.png", "video.mp4"


def looked_at(file: Path, on_progress: OnProgress = no_progress) -> VideoInfo:
    """Return the properties of a video that people are to watch.

    Raises
    ------
    FormatError
        If it can't be read, is cut off or damaged, or browsers don't play it.
    """
    info = probe(
        file,
        progress=lambda share: on_progress(f"looking at {file.name}", round(100 * share), 100),
    )
    if info.problem:
        raise FormatError(
            f"the video isn't whole: {info.problem}", where=str(file), fix="copy or make it again"
        )
    if not info.is_playable:
        kind = f"{info.codec!r} ({info.pixel_format}, {info.container or 'another container'})"
        raise FormatError(
            f"browsers don't play videos of the kind {kind}",
            where=str(file),
            fix=f"convert it: {to_mp4(file)}",
        )
    return info


def check_readable(videos: Sequence[OwnVideo], on_progress: OnProgress = no_progress) -> None:
    """Check that people can watch videos, that all parts are in their files, and that they are cut.

    Each file is decoded once, unless its properties are in the cache. The shortest part of each
    file is cut for a trial: the others are cut in the same way.

    Raises
    ------
    CorpusError
        If anything is wrong; it lists all.
    """
    errors: list[CorpusError] = []
    wrong: set[Path] = set()
    shortest: dict[Path, OwnVideo] = {}
    for item in (one for each in videos for one in (each, *each.views)):
        if item.file in wrong:
            continue
        try:
            info = looked_at(item.file, on_progress)
        except CorpusError as error:
            errors.append(error)
            wrong.add(item.file)
            continue
        try:
            _check_part(item, info)
        except CorpusError as error:
            errors.append(error)
            continue
        if item.part is not None:
            shortest[item.file] = min(shortest.get(item.file, item), item, key=_part_s)
    for number, (file, item) in enumerate(shortest.items()):
        on_progress("cutting a part of each video", number, len(shortest))
        try:
            _try_cut(item, looked_at(file))
        except CorpusError as error:
            errors.append(error)
    if errors:
        raise together(errors)


def _part_s(item: OwnVideo) -> float:
    start_s, end_s = item.part or (0.0, 0.0)
    return end_s - start_s


def _try_cut(item: OwnVideo, info: VideoInfo) -> None:
    """Cut a part, unless that was done, and compare its length with that in its manifest."""
    part = part_of(item)
    of_part = part.span(info)
    marker = cache_folder() / "cut-parts" / f"{part.digest(info.sha256)}-{CUT_VERSION}"
    if marker.exists():
        return
    with tempfile.TemporaryDirectory(prefix="ct-part-") as folder:
        trial = clip_path(Path(folder), info)
        cut(item.file, info, of_part, trial)
        result = probe(trial)
    if result.problem or abs(result.duration_s - of_part.duration_s) > 1.5 / info.fps:
        what = result.problem or f"it is {result.duration_s:g} s long, not {of_part.duration_s:g} s"
        raise FormatError(
            f"the part {item.video!r} of {item.file.name} can't be cut: {what}",
            where=item.where or str(item.file),
            fix=f"convert the video: {to_mp4(item.file)}",
        )
    with suppress(OSError):  # without a cache folder the next check cuts again
        marker.parent.mkdir(parents=True, exist_ok=True)
        write_bytes(marker, b"")


def check_rendered(folders: Sequence[Path], on_progress: OnProgress = no_progress) -> None:
    """Check that videos of ``ct render-videos`` are whole, and as long as their manifests say.

    Where PyAV isn't installed, which such studies need not have, nothing is checked.

    Raises
    ------
    CorpusError
        If one isn't; it lists all.
    """
    errors: list[CorpusError] = []
    for folder in folders if has_decoder() else ():
        file = folder / FILM
        try:
            info, stated_s = looked_at(file, on_progress), read_film(folder).duration_s
            if abs(info.duration_s - stated_s) > 1 / info.fps:
                raise FormatError(
                    f"the video is {info.duration_s:g} s long, and {stated_s:g} s in its manifest",
                    where=str(file),
                    fix="make it again with `ct render-videos --force`",
                )
        except CorpusError as error:
            errors.append(error)
    if errors:
        raise together(errors)


def _check_part(item: OwnVideo, info: VideoInfo) -> None:
    """Check that a part is in its file and can be cut, and that things are marked in its frame."""
    part = part_of(item)
    try:
        of_part = part.span(info)
    except FormatError as error:
        where = item.where or str(item.file)
        what = f"of {item.file.name}, {error.what}"
        raise FormatError(what, where=where, fix=error.fix) from error
    if item.things is not None:
        fitting_picture(item, png(first_picture(item.file, info, of_part)))


def part_of(item: OwnVideo) -> Part:
    """Return the part of a file that a video is."""
    start_s, end_s = item.part or (0.0, None)
    return Part(str(item.file), start_s, end_s)


def prepare(item: OwnVideo, base: Path, on_progress: OnProgress = no_progress) -> Path:
    """Make the folder with a video's manifest and poster, unless it is there.

    Parameters
    ----------
    base
        Parent of the folder. Another film or other things under the same name have another
        folder, so that earlier items stay as they were.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    FormatError
        If the video can't be watched, as :func:`looked_at` says, or doesn't have the part.
    """
    info, part = looked_at(item.file, on_progress), part_of(item)
    sha256, of_part = part.digest(info.sha256), part.span(info)
    key = f"{item.video}\0{sha256}"
    things = things_key(item.things) if item.things is not None else ""
    if things:
        key += f"\0{things}"
    folder = base / hashlib.sha256(key.encode()).hexdigest()[:20]
    content: dict[str, Any] = {
        "id": item.video,
        "has_scene": False,
        "steps": [],
        "metadata": dict(item.metadata),
        "sha256": sha256,
        "duration_s": of_part.duration_s,
        "fps": constant_rate(info, of_part),
        "size": [info.width, info.height],
        "cut": CUT_VERSION,
    }
    if things:
        content["things"] = things
    if item.views or item.curves:
        cameras = tuple(one.camera for one in (item, *item.views))
        content["beside"] = msgspec.to_builtins(Beside(cameras, item.curves_start_s))
    if item.part is not None or not plays_alike(item.file, info):
        content["part"] = msgspec.to_builtins(part)
    manifest, poster = folder / MANIFEST, folder / POSTER
    made = msgspec.json.encode(content)
    if poster.is_file() and manifest.is_file() and manifest.read_bytes() == made:
        return folder
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob(f"{CLIP}.*"):
        old.unlink(missing_ok=True)
    picture = png(first_picture(item.file, info, of_part))
    if item.things is not None:
        picture = fitting_picture(item, picture)
        write_bytes(folder / "segmentation.json", outlines_of(item.things))
    write_bytes(poster, picture)
    write_bytes(manifest, made)
    return folder


def played_file(item: OwnVideo, folder: Path) -> Path:
    """Return the file that people watch: the video, or what is cut, in a folder of `prepare`."""
    clip = clip_path(folder, looked_at(item.file))
    return clip if is_clip(clip) else item.file


def thumbnail(file: Path, part: Part | None = None) -> bytes:
    """Return a small picture, as JPEG, of a video's first frame or of a picture."""
    import cv2  # noqa: PLC0415 - large, and not always installed

    from corpus_tools.video.picture_file import decoded  # noqa: PLC0415 - as above

    if file.suffix.lower() in SUFFIXES:
        info = looked_at(file)
        span = (part or Part(str(file))).span(info)
        picture = first_picture(file, info, span)[..., ::-1]
    else:
        picture = decoded(regular_file.read_bytes(file), where=str(file))
    height, width = picture.shape[:2]
    scale = min(1.0, THUMBNAIL_PX / width)
    size = max(1, round(width * scale)), max(1, round(height * scale))
    small = cv2.resize(np.ascontiguousarray(picture), size, interpolation=cv2.INTER_AREA)
    is_written, content = cv2.imencode(".jpg", small)
    assert is_written  # noqa: S101 - any picture can be
    return content.tobytes()


def png(picture: NDArray[np.uint8]) -> bytes:
    """Return a picture of shape (height, width, 3), red, green and blue, as PNG."""
    import cv2  # noqa: PLC0415 - large, and not always installed

    is_written, content = cv2.imencode(".png", picture[..., ::-1])
    assert is_written  # noqa: S101 - any picture can be
    return content.tobytes()
