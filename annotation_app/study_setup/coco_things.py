"""What is where in the pictures of one's own videos: boxes and outlines from a COCO JSON file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

import cv2
import msgspec
import numpy as np
from cv2.typing import MatLike

from annotation_app.study_setup.every_problem import together
from corpus_tools.video.picture_file import MOST_PIXELS
from g3.errors import FormatError
from g3.storage import regular_file

MOST_THINGS = 200
"""Things in a picture: more nobody can tell apart on a page."""
FORM = 'COCO has "images", "annotations" and "categories"'

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
    """``id`` of the annotation as text, ``label``, ``box`` (x, y, width and height in pixels) and
    ``polygons`` of each."""


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


class _Category(msgspec.Struct, frozen=True):
    id: int | str
    name: str


class _Annotation(msgspec.Struct, frozen=True):
    id: int | str
    image_id: int | str
    category_id: int | str
    bbox: tuple[float, float, float, float]
    segmentation: list[list[float]] | Mask | None = None


class _Coco(msgspec.Struct, frozen=True):
    images: list[_Image]
    annotations: list[_Annotation]
    categories: list[_Category]


def read_things(path: Path, videos: Mapping[str, Path]) -> dict[str, PictureThings]:
    """The things in the pictures of videos, by the videos' names.

    An image is of the video that has its name, or whose file in `videos` has it, without the
    ending. A CorpusError lists all that is wrong with the file and what is in it.
    """
    coco = _decoded(path)
    files = {file.stem: name for name, file in videos.items()}
    shown = []
    for image in coco.images:  # the file may tell of more than a study shows
        stem = PurePosixPath(image.file_name).stem
        video = stem if stem in videos else files.get(stem)
        if video is not None:
            shown.append((video, image))
    wrong = [*_annotation_problems(coco), *_image_problems(coco, shown)]
    if wrong:
        errors = (FormatError(what, where=f"{path}: {at}", fix=fix) for at, what, fix in wrong)
        raise together(errors)
    labels = {category.id: category.name for category in coco.categories}
    found = {}
    for video, image in shown:
        still = (path.parent / image.file_name).resolve()
        of_image = (one for one in coco.annotations if one.image_id == image.id)
        things = tuple(_thing(one, labels[one.category_id]) for one in of_image)
        picture = still if still.is_file() else None
        found[video] = PictureThings(picture, image.width, image.height, things)
    return found


def _decoded(path: Path) -> _Coco:
    try:
        return msgspec.json.decode(regular_file.read_bytes(path), type=_Coco)
    except OSError as error:
        raise FormatError(
            f"the file can't be read: {error.strerror}", where=str(path), fix="correct its name"
        ) from error
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise FormatError(f"this is no COCO file: {error}", where=str(path), fix=FORM) from error


def _annotation_problems(coco: _Coco) -> Iterator[tuple[str, str, str]]:
    """Where something is wrong with an annotation, what, and what to do about it."""
    images = {image.id for image in coco.images}
    categories = {category.id for category in coco.categories}
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
    """The same of the images of videos, and of the boxes in them."""
    seen: set[str] = set()
    for video, image in shown:
        at = f"image {image.id}"
        if video in seen:
            yield at, f"two images are of the video {video!r}", "leave one out"
        seen.add(video)
        size = image.height, image.width
        of_image = [one for one in coco.annotations if one.image_id == image.id]
        if not of_image:
            yield at, "nothing is marked in it", "mark things, or leave it out"
        if len(of_image) > MOST_THINGS:
            what = f"there are {len(of_image)} things, and people see at most {MOST_THINGS}"
            yield at, what, "leave some out"
        for one in of_image:
            if what := _outside(one, image):
                fix = "correct its bbox: x, y, width and height in pixels"
                yield f"annotation {one.id}", what, fix
            if isinstance(one.segmentation, Mask) and one.segmentation.size != size:
                what = f"its mask has not the picture's {size[0]} rows and {size[1]} columns"
                yield f"annotation {one.id}", what, "correct its size, or leave it out"


def _outside(one: _Annotation, image: _Image) -> str:
    """What is wrong with a box; empty if nothing is."""
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


def _thing(one: _Annotation, label: str) -> Mapping[str, Any]:
    """A thing as ``segmentation.json`` has it; one without an outline is shown by its box."""
    x, y, width, height = one.bbox
    box = [[x, y], [x + width, y], [x + width, y + height], [x, y + height]]
    polygons = _polygons(one) or [box]
    return {"id": str(one.id), "label": label, "box": list(one.bbox), "polygons": polygons}


def outlines(mask: Mask) -> list[list[list[float]]]:
    """Around a mask: polygons of (x, y) in pixels, without holes; none around nothing.

    A ValueError says that the runs don't fill the picture, or that it is too large.
    """
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
    return cv2.approxPolyDP(outline, 1, closed=True) if len(outline) > MANY else outline


def _expanded(text: str) -> Sequence[int]:
    """Six bits a letter, the lowest first; from the third on, differences to the last but one."""
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
