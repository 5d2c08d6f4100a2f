"""What the answers to a grounding speak of, in the picture and on the map."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

from annotation_app.items.scenes import Scene
from annotation_app.tasks.agreement import AREA, PLACE, THING, Key

MARGIN_M = 2.0


@dataclass(frozen=True, slots=True)
class Outline:
    """Something to draw, as SVG has it.

    Parameters
    ----------
    kind
        ``thing``, ``place`` or ``area``: one that an answer has drawn.
    shown
        What the worker's page calls it; empty for what no answer speaks of.
    differs
        Whether the answers don't agree on it.
    polygons
        Corners of each, as the attribute ``points``.
    """

    kind: str
    shown: str
    differs: bool
    polygons: tuple[str, ...]


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
        The map's ``viewBox``, in metres with y downwards. The page's script turns the map as the
        worker's is.
    mapped
        Outlines on the map, in the same; none where only a picture is known.
    """

    video: str | None
    size: tuple[int, int]
    seen: tuple[Outline, ...]
    view: str
    mapped: tuple[Outline, ...]


def draw(
    scene: Scene,
    video: str | None,
    keys: Sequence[Key],
    shown: Mapping[Key, str],
    disputed: Collection[Key],
) -> Picture:
    """A scene, with what answers speak of.

    Parameters
    ----------
    keys
        What they speak of.
    shown
        What the worker's page calls things and places.
    disputed
        Of what they speak, that on which they don't agree.
    """
    size = scene.segmentation.get("width", 0), scene.segmentation.get("height", 0)

    def outline(key: Key, polygons: Sequence[Sequence[Sequence[float]]]) -> Outline:
        points = tuple(map(_points, polygons))
        name = shown.get(key, "") if key in keys else ""
        return Outline(key[0], name, key in disputed, points)

    seen = [
        outline((THING, thing["id"]), thing["polygons"])
        for thing in scene.segmentation.get("objects", [])
        if (THING, thing["id"]) in keys and thing["polygons"]
    ]
    if scene.is_picture:
        return Picture(video if all(size) else None, size, tuple(seen), "", ())
    # Those that are spoken of come last, to lie on top.
    things = sorted(scene.context.objects, key=lambda thing: (THING, thing.id) in keys)
    mapped = [outline((THING, thing.id), [_turned(thing.prism.xy.tolist())]) for thing in things]
    for key in keys:
        if key[0] == PLACE:
            mapped.append(outline(key, [_turned(scene.context.places[key[1]].prism.xy.tolist())]))
        elif key[0] == AREA:
            mapped.append(outline(key, [_turned(key[1])]))
    return Picture(video if all(size) else None, size, tuple(seen), _view(scene), tuple(mapped))


def _turned(corners: Iterable[Sequence[float]]) -> list[tuple[float, float]]:
    return [(x, -y) for x, y in corners]


def _view(scene: Scene) -> str:
    prisms = [
        *(thing.prism for thing in scene.context.objects),
        *(place.prism for place in scene.context.places),
    ]
    corners = [corner for prism in prisms for corner in prism.xy.tolist()]
    xs, ys = [x for x, _ in corners], [-y for _, y in corners]
    left, top = min(xs) - MARGIN_M, min(ys) - MARGIN_M
    return f"{left:.2f} {top:.2f} {max(xs) - left + MARGIN_M:.2f} {max(ys) - top + MARGIN_M:.2f}"


def _points(corners: Iterable[Sequence[float]]) -> str:
    return " ".join(f"{x:.2f},{y:.2f}" for x, y in corners)
