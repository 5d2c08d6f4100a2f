"""Things in the pictures of the user's videos: boxes and outlines from a COCO JSON file."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qs, unquote, urlsplit

import msgspec
import numpy as np

from annotation_app.study_setup.every_problem import together
from corpus_tools.tables.file_names import find_file, normal_name
from corpus_tools.tables.json_text import read_json
from corpus_tools.tables.table_reading import OnNote, no_note
from corpus_tools.video.picture_file import MOST_PIXELS
from g3.errors import CorpusError, FormatError

if TYPE_CHECKING:
    from cv2.typing import MatLike

MOST_THINGS = 200
"""Largest number of things in a picture: more are indistinguishable on a page."""
FORM = 'COCO has "images", "annotations" and "categories"'

MOST_NAMED = 10
"""Largest number of images named in a note."""
_PREFIX = re.compile(r"^[0-9a-f]{8}-")
"""Prefix that Label Studio writes before the name of a file that is sent to it."""
_NOT_STORED = re.compile(r"[^-\w.]")

MANY = 100
"""Corners from which on the steps of pixels are smoothed away."""
WHY = "its mask is no run-length encoding of COCO"


@dataclass(frozen=True, slots=True)
class PictureThings:
    """The things in a video's picture."""

    picture: Path | None
    """A still; None for the first frame."""
    width: int
    height: int
    """Width and height are the picture's, in pixels."""
    things: tuple[Mapping[str, Any], ...]
    """``id`` of the annotation or of its track as text, ``label``, ``box`` (x, y, width and height
    in pixels) and ``polygons`` of each. Things known at other moments than the video's first have
    ``moments``: ``time_s``, ``box``, ``polygons`` and ``is_keyframe`` of each, ascending; their own
    box is that of the first."""


class Mask(msgspec.Struct, frozen=True):
    """A mask: runs of pixels outside and inside a thing, in turn."""

    size: tuple[int, int]
    """Height and width of the picture, in pixels."""
    counts: list[int] | str
    """The runs' lengths, or the string into which COCO's tools compress them."""


class _Image(msgspec.Struct, frozen=True):
    id: int | str
    file_name: str
    width: int
    height: int
    video: Any = None
    """Name of the video, in files of this program; `file_name` gives it in others."""
    time_s: float | None = None
    """Moment of the video, in seconds; None for its picture: a still, or the first frame."""

    @property
    def moment_s(self) -> float:
        return self.time_s or 0.0


class _Category(msgspec.Struct, frozen=True):
    id: int | str
    name: str


class _Annotation(msgspec.Struct, frozen=True):
    id: int | str
    image_id: int | str
    category_id: int | str
    bbox: tuple[float, float, float, float]
    segmentation: list[list[float]] | Mask | None = None
    track_id: Any = None
    """The same for a thing at several moments."""
    keyframe: Any = True
    """False if a program made it of others."""


class _Coco(msgspec.Struct, frozen=True):
    images: list[_Image]
    annotations: list[_Annotation]
    categories: list[_Category]


def read_things(
    path: Path,
    videos: Mapping[str, Path],
    parts: Mapping[str, tuple[float, float]] | None = None,
    on_note: OnNote = no_note,
) -> dict[str, PictureThings]:
    """Read the things in the pictures of videos.

    Parameters
    ----------
    path
        A COCO file. An image is of the video that has its name, or whose file has it, without the
        ending. If there is none, its name is read as annotation tools write it: with Windows'
        paths, in addresses, and with a prefix of Label Studio. Images of one video at several
        moments (``time_s``) show the same thing where annotations have the same ``track_id``.
    videos
        The videos' files by the videos' names.
    parts
        Beginning and end in seconds, of the videos that are parts of their files.
    on_note
        Takes lines about images that are no video's, that were matched loosely, or in which nothing
        is marked.

    Returns
    -------
    dict
        By the names of the videos in which something is marked. Several may show the same file.

    Raises
    ------
    CorpusError
        If something is wrong with the file or what is in it; it lists all.
    """
    coco = read_json(path, _Coco, what="COCO file", fix=FORM)
    names = _Names(videos, parts or {})
    shown: list[tuple[str, _Image]] = []
    loose: list[str] = []
    wrong = [*_annotation_problems(coco)]
    unused: dict[int | str, str] = {}
    for image in coco.images:
        found, is_exact = names.of_image(image.file_name, image.video)
        if len({names.shows(video) for video in found}) > 1:
            fix = "call the image as one of them is called"
            what = f"its name {image.file_name!r} is of several videos: {', '.join(found)}"
            wrong.append((f"image {image.id}", what, fix))
        elif not found:
            unused[image.id] = image.file_name
        else:
            shown += [(video, image) for video in found]
            loose += [] if is_exact else [f"{image.file_name!r} of {', '.join(found)}"]
    wrong += _image_problems(coco, shown)
    if wrong:
        errors = (FormatError(what, where=f"{path}: {at}", fix=fix) for at, what, fix in wrong)
        raise together(errors)
    if unused:
        count = sum(one.image_id in unused for one in coco.annotations)
        on_note(
            f"{path}: {len(unused)} of {len(coco.images)} images, with {count} of "
            f"{len(coco.annotations)} annotations, are of no video and aren't used: "
            f"{_first(map(repr, unused.values()))}"
        )
    if loose:
        on_note(f"{path}: taken for images of videos: {_first(loose)}")
    labels = {category.id: category.name for category in coco.categories}
    of_image = _by_image(coco)
    images: dict[str, list[_Image]] = {}
    for video, image in shown:
        images.setdefault(video, []).append(image)
    things = {
        video: _picture(path.parent, of_video, of_image, labels)
        for video, of_video in images.items()
    }
    bare = [one.file_name for video in images for one in images[video] if not things[video].things]
    if bare:
        on_note(f"{path}: nothing is marked in: {_first(map(repr, bare))}")
    return {video: found for video, found in things.items() if found.things}


def _picture(
    folder: Path,
    images: Sequence[_Image],
    of_image: Mapping[int | str, Sequence[_Annotation]],
    labels: Mapping[int | str, str],
) -> PictureThings:
    """Return the things in a video's images, whose names begin at a folder."""
    moments = sorted(images, key=lambda image: image.moment_s)
    first = moments[0]
    still = find_file(folder, first.file_name).resolve()
    is_still = first.time_s is None and os.path.isfile(still)  # noqa: PTH113 - it may be too long
    things = _things(moments, of_image, labels)
    return PictureThings(still if is_still else None, first.width, first.height, things)


def images_of(path: Path, videos: Mapping[str, Path], video: str) -> set[int | str]:
    """Return the ids of the images in a COCO file that are of a video, as for `read_things`."""
    coco = read_json(path, _Coco, what="COCO file", fix=FORM)
    names = _Names(videos, {})
    found = ((image.id, names.of_image(image.file_name, image.video)[0]) for image in coco.images)
    return {image for image, of_videos in found if video in of_videos}


def is_coco(file: Path) -> bool:
    """Check that a file has the form of a COCO file."""
    try:
        read_json(file, _Coco, what="COCO file", fix=FORM)
    except CorpusError:
        return False
    return True


class _Names:
    """The names by which images may be those of videos."""

    def __init__(
        self, videos: Mapping[str, Path], parts: Mapping[str, tuple[float, float]]
    ) -> None:
        self._files, self._parts = videos, parts
        self._ids = {normal_name(video): [video] for video in videos}
        self._stems: dict[str, list[str]] = {}
        self._plain: dict[str, list[str]] = {}
        for video, file in videos.items():
            self._stems.setdefault(normal_name(file.stem), []).append(video)
            for plain in {_plain(video), _plain(file.stem)}:
                self._plain.setdefault(plain, []).append(video)

    def shows(self, video: str) -> tuple[Path, tuple[float, float] | None]:
        """Return what a video shows: its file, and the part of it."""
        return self._files[video], self._parts.get(video)

    def of_image(self, name: str, video: Any = None) -> tuple[list[str], bool]:
        """Return the videos that an image is of, and if it has their very name."""
        if isinstance(video, str):
            return self._ids.get(normal_name(video), []), True
        stem = normal_name(PurePosixPath(name).stem)
        exact = self._ids.get(stem) or self._stems.get(stem)
        if exact:
            return exact, True
        found = (video for plain in _plain_names(name) for video in self._plain.get(plain, ()))
        return list(dict.fromkeys(found)), False


def _plain_names(name: str) -> set[str]:
    """Return the possible names of a tool's image: without address, folders and prefix."""
    address = urlsplit(name) if "?" in name or "://" in name else None
    if address is not None:
        name = parse_qs(address.query).get("d", [address.path])[0]
    stems = {PureWindowsPath(text).stem for text in (name, unquote(name))}
    return {_plain(stem) for stem in stems | {_PREFIX.sub("", stem) for stem in stems}} - {""}


def _plain(name: str) -> str:
    """Return a name as Label Studio stores the file: of letters, digits and the like."""
    return _NOT_STORED.sub("", normal_name(name).strip().replace(" ", "_"))


def _first(names: Iterable[str]) -> str:
    every = list(names)
    return ", ".join(every[:MOST_NAMED]) + (" …" if len(every) > MOST_NAMED else "")


def _annotation_problems(coco: _Coco) -> Iterator[tuple[str, str, str]]:
    """Yield the place of each fault in an annotation, the fault, and its fix."""
    images = {image.id for image in coco.images}
    categories = {category.id for category in coco.categories}
    for kind, records in (("image", coco.images), ("category", coco.categories)):
        counts = Counter(record.id for record in records)
        for id_ in (id_ for id_, count in counts.items() if count > 1):
            yield f"{kind} {id_}", f"{counts[id_]} times this id is given", "change the others"
    ids: set[str] = set()
    for one in coco.annotations:
        at = f"annotation {one.id}"
        if str(one.id) in ids:
            yield at, "two annotations have this id", "change one"
        ids.add(str(one.id))
        if one.image_id not in images:
            yield at, f"there is no image {one.image_id}", "correct its image_id"
        if one.category_id not in categories:
            yield at, f"there is no category {one.category_id}", "correct its category_id"
        try:
            _polygons(one)
        except ValueError as error:
            yield at, str(error), "correct it, or leave it out"


def _image_problems(
    coco: _Coco, shown: Sequence[tuple[str, _Image]]
) -> Iterator[tuple[str, str, str]]:
    """Yield place, fault and fix of the images of videos, and of the boxes in them."""
    seen: dict[tuple[str, float], _Image] = {}
    sizes: dict[str, tuple[int, int]] = {}
    annotations = _by_image(coco)
    for video, image in shown:
        at = f"image {image.id}"
        if (video, image.moment_s) in seen:
            yield at, f"two images are of the video {video!r}", "leave one out"
        seen[video, image.moment_s] = image
        size = image.height, image.width
        if sizes.setdefault(video, size) != size:
            yield at, f"images of the video {video!r} differ in size", "give them the same"
        of_image = annotations.get(image.id, [])
        if len(of_image) > MOST_THINGS:
            what = f"there are {len(of_image)} things, and people see at most {MOST_THINGS}"
            yield at, what, "leave some out"
        names = Counter(thing_id(one, image) for one in of_image)
        for name in (name for name, count in names.items() if count > 1):
            yield at, f"{names[name]} annotations are of the thing {name}", "leave the others out"
        for one in of_image:
            if what := _outside(one, image):
                fix = "correct its bbox: x, y, width and height in pixels"
                yield f"annotation {one.id}", what, fix
            if isinstance(one.segmentation, Mask) and one.segmentation.size != size:
                what = f"its mask has not the picture's {size[0]} rows and {size[1]} columns"
                yield f"annotation {one.id}", what, "correct its size, or leave it out"


def _outside(one: _Annotation, image: _Image) -> str:
    """Return the fault of a box; empty if there is none."""
    x, y, width, height = one.bbox
    if width <= 0 or height <= 0:
        return "its box has no size"
    if x < -1 or y < -1 or x + width > image.width + 1 or y + height > image.height + 1:
        return f"its box is not in the picture of {image.width} by {image.height} pixels"
    return ""


def _polygons(one: _Annotation) -> list[list[list[float]]]:
    if isinstance(one.segmentation, Mask):
        return outlines(one.segmentation)
    for outline in one.segmentation or ():
        if len(outline) < 6 or len(outline) % 2:
            raise ValueError("its segmentation is no list of x, y, x, y …")
    return [
        [list(xy) for xy in zip(outline[::2], outline[1::2], strict=True)]
        for outline in one.segmentation or ()
    ]


def _by_image(coco: _Coco) -> Mapping[int | str, Sequence[_Annotation]]:
    found: dict[int | str, list[_Annotation]] = {}
    for one in coco.annotations:
        found.setdefault(one.image_id, []).append(one)
    return found


def thing_id(one: _Annotation, image: _Image) -> str:
    """Return the id of an annotation's thing: that of its track, at moments of a video."""
    is_tracked = image.time_s is not None and one.track_id is not None
    return str(one.track_id if is_tracked else one.id)


def _things(
    images: Sequence[_Image],
    of_image: Mapping[int | str, Sequence[_Annotation]],
    labels: Mapping[int | str, str],
) -> tuple[Mapping[str, Any], ...]:
    """Return the things at a video's moments, in their order, as in ``segmentation.json``."""
    found: dict[str, dict[str, Any]] = {}
    for image in images:
        for one in of_image.get(image.id, ()):
            shape = _shape(one)
            id_ = thing_id(one, image)
            thing = found.setdefault(
                id_, {"id": id_, "label": labels[one.category_id], **shape, "moments": []}
            )
            moment = {"time_s": image.moment_s, **shape, "is_keyframe": one.keyframe is not False}
            thing["moments"].append(moment)
    for thing in found.values():
        if len(thing["moments"]) == 1 and not thing["moments"][0]["time_s"]:
            del thing["moments"]
    return tuple(found.values())


def _shape(one: _Annotation) -> dict[str, Any]:
    """Return an annotation's box and polygons; one without an outline is shown by its box."""
    x, y, width, height = one.bbox
    box = [[x, y], [x + width, y], [x + width, y + height], [x, y + height]]
    return {"box": list(one.bbox), "polygons": _polygons(one) or [box]}


def outlines(mask: Mask) -> list[list[list[float]]]:
    """Return polygons of (x, y) in pixels around a mask, without holes; none around nothing.

    A ValueError says that the runs don't fill the picture, or that it is too large.
    """
    import cv2  # noqa: PLC0415 - large, and not always installed

    height, width = mask.size
    runs = _expanded(mask.counts) if isinstance(mask.counts, str) else mask.counts
    pixels = height * width
    if min(height, width, *runs) < 0 or sum(runs) != pixels or pixels > MOST_PIXELS:
        raise ValueError(WHY)
    inside = np.arange(len(runs)) % 2
    mask_pixels = np.repeat(inside.astype(np.uint8), runs).reshape(width, height).T
    # OpenCV goes through the middle of pixels: of twice as many, so that lines of pixels have area.
    doubled = cv2.resize(mask_pixels, None, fx=2, fy=2, interpolation=cv2.INTER_NEAREST)
    found, _ = cv2.findContours(doubled, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    return [(_smooth(one)[:, 0] / 2).tolist() for one in found]


def _smooth(outline: MatLike) -> MatLike:
    import cv2  # noqa: PLC0415 - as above

    return cv2.approxPolyDP(outline, 1, closed=True) if len(outline) > MANY else outline


def _expanded(text: str) -> Sequence[int]:
    """Return the numbers of a COCO run-length text.

    Each letter has six bits, the lowest first; the numbers from the third on are differences to
    the last but one.
    """
    runs: list[int] = []
    value = shift = 0
    for letter in text:
        bits = ord(letter) - 48
        if not 0 <= bits < 64:
            raise ValueError(WHY)
        value |= (bits & 0x1F) << shift
        shift += 5
        if bits & 0x20:
            continue
        if bits & 0x10:
            value -= 1 << shift
        runs.append(value + runs[-2] if len(runs) > 2 else value)
        value = shift = 0
    if shift:
        raise ValueError(WHY)
    return runs
