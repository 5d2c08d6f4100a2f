"""Things that people draw in the pictures of videos, kept in a COCO file like anybody else's."""

from __future__ import annotations

import hashlib
import itertools
import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeAlias

import msgspec

from annotation_app.study_setup.coco_things import FORM, MOST_THINGS, PictureThings, images_of
from annotation_app.tasks.drawn_answers import Coordinate
from corpus_tools.tables.file_names import find_file
from corpus_tools.tables.json_text import read_json
from g3.errors import FormatError
from g3.storage.atomic_file import write_bytes

UNNAMED = "thing"
"""Name of things that nobody has named."""
MOST_MOMENTS = 5000

Corner: TypeAlias = tuple[Coordinate, Coordinate]
Polygon: TypeAlias = Annotated[list[Corner], msgspec.Meta(min_length=3, max_length=2000)]
Outline: TypeAlias = Annotated[list[Polygon], msgspec.Meta(min_length=1, max_length=200)]
Pixels: TypeAlias = Annotated[int, msgspec.Meta(ge=1, le=1 << 15)]


class Moment(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A thing's outline at a moment of its video."""

    time_s: Annotated[float, msgspec.Meta(ge=0, le=1e6)]
    polygons: Outline
    is_keyframe: bool = True
    """False if a program has carried it on to here."""

    @property
    def box(self) -> list[float]:
        """The box around it: x, y, width and height in pixels."""
        xs, ys = zip(*(corner for polygon in self.polygons for corner in polygon), strict=True)
        x, y = min(xs), min(ys)
        return [round(value, 2) for value in (x, y, max(xs) - x, max(ys) - y)]


class DrawnThing(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A thing in a video's picture."""

    id: Annotated[str, msgspec.Meta(pattern=r"^[\w.-]{1,64}$")]
    name: Annotated[str, msgspec.Meta(max_length=200)]
    is_box: bool
    moments: Annotated[list[Moment], msgspec.Meta(min_length=1, max_length=MOST_MOMENTS)]


def drawn_things(things: PictureThings | None) -> list[DrawnThing]:
    """Return the things of a video as they are drawn."""
    return [] if things is None else [_drawn(thing) for thing in things.things]


def state_of(things: PictureThings | None) -> str:
    """Return a digest that changes when the things of a video do."""
    return hashlib.sha256(msgspec.json.encode(drawn_things(things))).hexdigest()[:16]


def names_in(file: Path | None) -> list[str]:
    """Return the names of things in a COCO file, the most frequent first."""
    if file is None or not file.is_file():
        return []
    document = read_json(file, dict[str, Any], what="COCO file", fix=FORM)
    counts = Counter(one.get("category_id") for one in document.get("annotations", []))
    named = sorted(document.get("categories", []), key=lambda one: -counts[one.get("id")])
    return [one["name"] for one in named if one["name"] not in ("", UNNAMED)]


@dataclass(frozen=True, slots=True)
class DrawnPicture:
    """A video's picture with what is drawn in it."""

    video: str
    width: int
    height: int
    """Width and height of the picture, in pixels."""
    things: Sequence[DrawnThing]
    before: PictureThings | None = None
    """The earlier things: those that are the same keep their annotations."""


def write_drawn(
    source: Path | None, target: Path, videos: Mapping[str, Path], drawn: DrawnPicture
) -> int:
    """Write a COCO file with other things of one video.

    Parameters
    ----------
    source
        The file whose other content stays as it is; None for none.
    videos
        The videos' files by the videos' names, as for
        :func:`~annotation_app.study_setup.coco_things.read_things`.

    Returns
    -------
    int
        The number of annotations in the new file.

    Raises
    ------
    FormatError
        If the things can't be kept.
    """
    _check(drawn)
    document: dict[str, Any] = {"images": [], "annotations": [], "categories": []}
    if source is not None:
        document = read_json(source, dict[str, Any], what="COCO file", fix=FORM)
        mine = images_of(source, videos, drawn.video)
        if source.parent != target.parent:
            _move_stills(document, source.parent, target.parent)
    else:
        mine = set()
    _put(document, mine, drawn)
    target.parent.mkdir(parents=True, exist_ok=True)
    write_bytes(target, msgspec.json.encode(document))
    return len(document["annotations"])


def _drawn(thing: Mapping[str, Any]) -> DrawnThing:
    moments = thing.get("moments") or [{"time_s": 0.0, **thing, "is_keyframe": True}]
    return DrawnThing(
        thing["id"],
        thing["label"],
        all(one["polygons"] == [_corners(one["box"])] for one in moments),
        [
            Moment(
                one["time_s"],
                [[(x, y) for x, y in polygon] for polygon in one["polygons"]],
                one["is_keyframe"],
            )
            for one in moments
        ],
    )


def _corners(box: Sequence[float]) -> list[list[float]]:
    x, y, width, height = box
    return [[x, y], [x + width, y], [x + width, y + height], [x, y + height]]


def _check(drawn: DrawnPicture) -> None:
    things = drawn.things
    if len(things) > MOST_THINGS:
        what = f"there are {len(things)} things, and people see at most {MOST_THINGS}"
        raise FormatError(what, fix="delete some")
    for number, thing in enumerate(things, start=1):
        for moment in thing.moments:
            x, y, width, height = moment.box
            right, bottom = drawn.width + 1, drawn.height + 1
            is_in = min(x, y) >= -1 and x + width <= right and y + height <= bottom
            if width <= 0 or height <= 0 or not is_in:
                what = f"thing {number} isn't in the picture, or has no size"
                raise FormatError(what, fix="draw it again")
    if len({thing.id for thing in things}) < len(things):
        raise FormatError("two things have the same id", fix="load the page again")


def _move_stills(document: dict[str, Any], old: Path, new: Path) -> None:
    """Have a copy of a COCO file name the same pictures."""
    for image in document["images"]:
        still = find_file(old, image["file_name"])
        if os.path.isfile(still):  # noqa: PTH113 - a name may be too long for a Path's own method
            image["file_name"] = os.path.relpath(still, new)


def _put(document: dict[str, Any], mine: set[int | str], drawn: DrawnPicture) -> None:
    """Put a video's things into a document in place of those in the images that are `mine`."""
    things = drawn.things
    same = {thing.id: thing.moments for thing in drawn_things(drawn.before)}
    before = {
        round(image.get("time_s") or 0.0, 3): image
        for image in document["images"]
        if image["id"] in mine
    }
    old = {str(one["id"]): one for one in document["annotations"] if one["image_id"] in mine}
    kept = [one for one in document["annotations"] if one["image_id"] not in mine]
    taken = {str(one["id"]) for one in kept}
    if clash := taken & {thing.id for thing in things}:
        raise FormatError(f"another thing has the id {min(clash)}", fix="load the page again")
    new_ids = _after(one["id"] for one in (*document["annotations"], *map(_record, things)))
    new_images = _after(image["id"] for image in document["images"])
    images = {t: image for t, image in before.items() if image.get("time_s") is None}
    for thing in things:
        category = _category(document, thing.name.strip() or UNNAMED)
        for number, moment in enumerate(sorted(thing.moments, key=lambda one: one.time_s)):
            t = round(moment.time_s, 3)
            if t not in images:
                images[t] = before.get(t) or _image(next(new_images), drawn, t)
            earlier = old.get(thing.id, {}) if number == 0 else {}
            is_same = earlier and thing.id in same and same[thing.id][0].polygons == moment.polygons
            annotation = {
                "iscrowd": 0,
                **earlier,
                "id": _as_id(thing.id) if number == 0 else next(new_ids),
                "image_id": images[t]["id"],
                "category_id": category,
                **({} if is_same else _outline(thing, moment)),
            }
            if len(thing.moments) > 1:
                annotation |= {"track_id": _as_id(thing.id), "keyframe": moment.is_keyframe}
            else:
                annotation.pop("track_id", None)
            kept.append(annotation)
    others = [image for image in document["images"] if image["id"] not in mine]
    is_moving = any(len(thing.moments) > 1 for thing in things)
    for t, image in images.items():
        # A first frame among other moments says so; else readers take it for a picture of its own.
        if (is_moving or t) and image.get("time_s") is None:
            image |= {"video": drawn.video, "time_s": t}
    document["images"] = others + [images[t] for t in sorted(images)]
    document["annotations"] = kept
    used = {one["category_id"] for one in kept}
    document["categories"] = [
        one for one in document["categories"] if one["name"] != UNNAMED or one["id"] in used
    ]


def _outline(thing: DrawnThing, moment: Moment) -> dict[str, Any]:
    """Return an annotation's box, area and segmentation."""
    _, _, width, height = moment.box
    if thing.is_box:
        return {"bbox": moment.box, "area": round(width * height, 2), "segmentation": []}
    flat = [[value for corner in polygon for value in corner] for polygon in moment.polygons]
    area = round(sum(map(_area, moment.polygons)), 2)
    return {"bbox": moment.box, "area": area, "segmentation": flat}


def _area(polygon: Sequence[Corner]) -> float:
    pairs = zip(polygon, [*polygon[1:], polygon[0]], strict=True)
    return abs(sum(x * v - u * y for (x, y), (u, v) in pairs)) / 2


def _image(id_: int, drawn: DrawnPicture, t: float) -> dict[str, Any]:
    name = f"{drawn.video}-{t:.3f}.png" if t else f"{drawn.video}.png"
    about = {"file_name": name, "width": drawn.width, "height": drawn.height}
    return {"id": id_, **about, "video": drawn.video, "time_s": t}


def _category(document: dict[str, Any], name: str) -> int | str:
    for one in document["categories"]:
        if one["name"] == name:
            found: int | str = one["id"]
            return found
    new = next(_after(one["id"] for one in document["categories"]))
    document["categories"].append({"id": new, "name": name})
    return new


def _record(thing: DrawnThing) -> dict[str, Any]:
    return {"id": _as_id(thing.id)}


def _as_id(text: str) -> int | str:
    """Return an id as other tools want it: a number, where it can be one."""
    return int(text) if text.isdecimal() and str(int(text)) == text else text


def _after(ids: Iterable[int | str]) -> Iterator[int]:
    """Count on from the largest number of `ids`."""
    return itertools.count(max((one for one in ids if isinstance(one, int)), default=0) + 1)
