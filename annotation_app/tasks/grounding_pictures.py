"""What the answers to a grounding speak of, in the picture and on the map."""

from __future__ import annotations

import string
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from sqlalchemy.orm import Session

from annotation_app.items.item_scenes import scene_of
from annotation_app.items.media import media_files
from annotation_app.items.scenes import Scene
from annotation_app.store.models import Item, Record

MARGIN_M = 2.0

Point: TypeAlias = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Outline:
    """Something to draw, as SVG has it.

    Parameters
    ----------
    label
        Written at `at`; empty for what no answer speaks of.
    kind
        ``object``, ``place`` or ``area``: one that an answer has drawn.
    polygons
        Corners of each, as the attribute ``points``.
    """

    label: str
    kind: str
    polygons: tuple[str, ...]
    at: Point


@dataclass(frozen=True, slots=True)
class Picture:
    """Two views of a scene.

    Parameters
    ----------
    video
        Its public name; None without pictures.
    size
        Of the video, in pixels.
    seen
        Outlines on the first frame, in pixels.
    view
        The map's ``viewBox``, in metres with y downwards.
    mapped
        Outlines on the map, in the same; none where only a picture is known.
    """

    video: str | None
    size: tuple[int, int]
    seen: tuple[Outline, ...]
    view: str
    mapped: tuple[Outline, ...]


def lettered(groundings: Iterable[Record]) -> dict[str, str]:
    """A letter for each object that groundings name, in the order in which they do."""
    ids = dict.fromkeys(name for grounding in groundings for name in grounding["objects"])
    return {name: _letters(number) for number, name in enumerate(ids)}


def draw(session: Session, item: Item, groundings: Sequence[Record]) -> Picture:
    """The scene of an item, with what groundings of its clauses speak of."""
    name = item.payload["video"]
    scene = scene_of(session, item.study_id, name)
    letters = lettered(groundings)
    size = scene.segmentation.get("width", 0), scene.segmentation.get("height", 0)
    video = media_files(session, item.study_id, name).public.get("video") if all(size) else None
    if scene.is_picture:
        return Picture(video, size, tuple(_seen(scene, letters)), "", ())
    mapped = (*_things(scene, letters), *_places(scene, groundings), *_areas(groundings))
    return Picture(video, size, tuple(_seen(scene, letters)), _view(scene), mapped)


def _seen(scene: Scene, letters: Mapping[str, str]) -> Iterable[Outline]:
    for thing in scene.segmentation.get("objects", []):
        if thing["id"] in letters and thing["polygons"]:
            left, top, width, height = thing["box"]
            middle = left + width / 2, top + height / 2
            polygons = tuple(_points(corners) for corners in thing["polygons"])
            yield Outline(letters[thing["id"]], "object", polygons, middle)


def _things(scene: Scene, letters: Mapping[str, str]) -> Iterable[Outline]:
    # Those with a letter come last, to lie on top.
    for thing in sorted(scene.context.objects, key=lambda thing: thing.id in letters):
        yield _mapped(letters.get(thing.id, ""), "object", thing.prism.xy.tolist())


def _places(scene: Scene, groundings: Iterable[Record]) -> Iterable[Outline]:
    indices = {
        place["place"]
        for grounding in groundings
        for place in grounding["places"]
        if place.get("place") is not None
    }
    for index in sorted(indices):
        yield _mapped(f"{index}", "place", scene.context.places[index].prism.xy.tolist())


def _areas(groundings: Iterable[Record]) -> Iterable[Outline]:
    for grounding in groundings:
        for place in grounding["places"]:
            if place.get("place") is None:
                yield _mapped("", "area", place["xy"])


def _mapped(label: str, kind: str, corners: Sequence[Sequence[float]]) -> Outline:
    turned = [(x, -y) for x, y in corners]
    return Outline(label, kind, (_points(turned),), _middle(turned))


def _view(scene: Scene) -> str:
    prisms = [
        *(thing.prism for thing in scene.context.objects),
        *(place.prism for place in scene.context.places),
    ]
    corners = [corner for prism in prisms for corner in prism.xy.tolist()]
    xs, ys = [x for x, _ in corners], [-y for _, y in corners]
    left, top = min(xs) - MARGIN_M, min(ys) - MARGIN_M
    return f"{left:.2f} {top:.2f} {max(xs) - left + MARGIN_M:.2f} {max(ys) - top + MARGIN_M:.2f}"


def _middle(corners: Sequence[Point]) -> Point:
    xs, ys = zip(*corners, strict=True)
    return sum(xs) / len(xs), sum(ys) / len(ys)


def _points(corners: Iterable[Sequence[float]]) -> str:
    return " ".join(f"{x:.2f},{y:.2f}" for x, y in corners)


def _letters(number: int) -> str:
    """A to Z, then AA and so on."""
    most, last = divmod(number, 26)
    return (_letters(most - 1) if most else "") + string.ascii_uppercase[last]
