"""Comparison of answers to a grounding: their common and differing parts, in words and drawn."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import msgspec
from sqlalchemy.orm import Session

from annotation_app.items.item_scenes import scene_of
from annotation_app.items.media import media_files
from annotation_app.items.scenes import (
    Scene,
    aliases,
    place_names,
    scene_payload,
    thing_names,
    with_drawn,
)
from annotation_app.store.models import Item, Record
from annotation_app.tasks.agreement import AREA, CLAUSE_TYPE, PLACE, THING, WORDS, Key, Part
from annotation_app.tasks.clause_words import HAPPENING, clauses_of
from annotation_app.tasks.task_record import Compared
from g3.sdc.clauses import SDC, breadth_first
from g3.sdc.sdc_notation import from_json

MARGIN_M = 2.0


@dataclass(frozen=True, slots=True)
class Choice:
    """An answer's choice for a clause."""

    text: str
    """In words."""
    shown: str
    """Name of the thing or place on the worker's page; empty for everything else."""
    differs: bool
    """True if another answer lacks this choice."""


@dataclass(frozen=True, slots=True)
class ComparedClause:
    """A clause and each answer's choices for it, in the order of the answers."""

    node: int
    phrase: str
    choices: tuple[tuple[Choice, ...], ...]
    times: tuple[tuple[float, float], ...]
    """For an EVENT or a PATH, the part of the video by each answer, in percent of it."""

    @property
    def differs(self) -> bool:
        """True if the answers disagree."""
        return any(choice.differs for choices in self.choices for choice in choices)


@dataclass(frozen=True, slots=True)
class Outline:
    """Something to draw, as SVG has it."""

    kind: str
    """``thing``, ``place`` or ``area``: one that an answer has drawn."""
    shown: str
    """Name on the worker's page; empty for things in no answer."""
    differs: bool
    """True if the answers disagree on the thing."""
    polygons: tuple[str, ...]
    """Corners of each, as the attribute ``points``."""


@dataclass(frozen=True, slots=True)
class Picture:
    """Two views of a scene."""

    video: str | None
    """Its public name; None without pictures."""
    size: tuple[int, int]
    """Width and height of the video, in pixels."""
    seen: tuple[Outline, ...]
    """Outlines on the first frame, in pixels."""
    view: str
    """The map's ``viewBox``, in metres with y downwards. The page's script turns the map as the
    worker's is."""
    mapped: tuple[Outline, ...]
    """Outlines on the map, in the same; none where only a picture is known."""


def grounding_key(grounding: Record) -> bytes:
    """Return the part of a grounding that equal groundings of a clause share."""
    return msgspec.json.encode(
        (sorted(grounding["objects"]), grounding["places"], grounding["cant_tell"])
    )


def essence(body: Record) -> Any:
    """Return the part that agreeing answers share: all but the time people took."""
    return body["trims"], {node: grounding_key(g) for node, g in body["groundings"].items()}


def shared_part(one: Record, other: Record) -> float:
    """Return the share of the clauses that two answers ground alike."""
    first, second = one["groundings"], other["groundings"]
    nodes = first.keys() | second.keys()
    alike = sum(
        node in first
        and node in second
        and grounding_key(first[node]) == grounding_key(second[node])
        for node in nodes
    )
    return alike / len(nodes) if nodes else 1.0


def compare(session: Session, item: Item, bodies: Sequence[Record], salt: bytes) -> Compared:
    """Return each clause's choices, and a picture of all of them, with differences marked."""
    video = item.payload["video"]
    scene = with_drawn(scene_of(session, item.study_id, video), drawn_in(bodies))
    names = aliases(scene, item.id, salt)
    shown: Mapping[Key, str] = {
        **{(THING, real): alias for alias, real in names.objects.items()},
        **{(PLACE, index): alias for alias, index in names.places.items()},
    }
    files = media_files(session, item.study_id, video).public
    clauses = list(_clauses(item, bodies, scene, shown))
    picture = _drawn(scene, files.get("video"), _all_keys(bodies), shown, _disputed_keys(bodies))
    about = {"clauses": clauses, "picture": picture, "scene": scene_payload(scene, names, files)}
    return Compared(tuple(range(len(bodies))), about)


def drawn_in(bodies: Iterable[Record]) -> Iterator[Record]:
    """Yield the things that people have drawn in answers."""
    for body in bodies:
        yield from body.get("drawn", [])


def disputed_parts(item: Item, bodies: Sequence[Record]) -> Iterator[Part]:
    """Yield the clauses of a command, their words, and the things and places that people chose."""
    for clause, _, said in _said_of(item, bodies):
        differs = len(set(said)) > 1
        yield Part(CLAUSE_TYPE, clause["type"], differs)
        yield Part(WORDS, clause["phrase"].lower(), differs)
        for kind, what in dict.fromkeys(key for keys in said for key in keys):
            if kind in (THING, PLACE):
                in_all = all((kind, what) in keys for keys in said)
                yield Part(kind, str(what), not in_all, item.payload["video"])


def _said_of(
    item: Item, bodies: Sequence[Record]
) -> Iterator[tuple[Record, SDC, list[tuple[Key, ...]]]]:
    """Yield the clauses of a command, and each answer's choices for them."""
    sdcs = from_json(item.payload["sdcs"])
    nodes = list(breadth_first(sdcs))
    for clause in clauses_of(sdcs):
        sdc = nodes[clause["node"]]
        yield clause, sdc, [_said(body, str(clause["node"]), sdc) for body in bodies]


def _clauses(
    item: Item, bodies: Sequence[Record], scene: Scene, shown: Mapping[Key, str]
) -> Iterator[ComparedClause]:
    duration_s, words = scene.duration_s, _Words(scene)
    for clause, sdc, said in _said_of(item, bodies):
        times: tuple[tuple[float, float], ...] = ()
        if sdc.type in HAPPENING:
            node = str(clause["node"])
            parts = (body["trims"].get(node, (0.0, duration_s)) for body in bodies)
            whole = max(duration_s, 0.1)
            times = tuple(
                (100 * start / whole, 100 * (end - start) / whole) for start, end in parts
            )
        choices = tuple(
            tuple(
                Choice(words.of(key), shown.get(key, ""), any(key not in other for other in said))
                for key in keys
            )
            for keys in said
        )
        yield ComparedClause(clause["node"], clause["phrase"], choices, times)


def _said(body: Record, node: str, sdc: SDC) -> tuple[Key, ...]:
    """Return an answer's choices for a clause."""
    if sdc.type in HAPPENING:
        part = body["trims"].get(node)
        return (("time", None if part is None else tuple(part)),)
    return tuple(_chosen(body["groundings"].get(node))) or (("nothing", None),)


def _chosen(grounding: Record | None) -> Iterator[Key]:
    if grounding is None:
        return
    if grounding["cant_tell"]:
        yield "can't tell", None
    for name in grounding["objects"]:
        yield THING, name
    for place in grounding["places"]:
        if place.get("place") is not None:
            yield PLACE, place["place"]
        else:
            yield AREA, tuple(map(tuple, place["xy"]))


def choices_in_words(session: Session, item: Item, body: Record) -> list[tuple[str, str]]:
    """Return each clause's words and what an answer chose for them, in words."""
    scene = scene_of(session, item.study_id, item.payload["video"])
    words = _Words(with_drawn(scene, drawn_in([body])))
    return [
        (clause["phrase"], ", ".join(map(words.of, keys)))
        for clause, _, (keys,) in _said_of(item, [body])
    ]


class _Words:
    """Words for choices in a scene."""

    def __init__(self, scene: Scene) -> None:
        self._things = thing_names(scene.context)
        self._places = place_names(scene.context)

    def of(self, key: Key) -> str:
        """Return a choice in words."""
        kind, what = key
        if kind == THING:
            return self._things.get(what, "a thing that is no longer there")
        if kind == PLACE:
            return self._places[what]
        if kind == AREA:
            xs, ys = zip(*what, strict=True)
            return f"area around ({sum(xs) / len(xs):.1f}, {sum(ys) / len(ys):.1f}) m"
        if kind == "time":
            return "the whole video" if what is None else f"{what[0]:.1f} to {what[1]:.1f} s"
        return kind


def _disputed_keys(bodies: Sequence[Record]) -> set[Key]:
    """Return the things, places and areas that not all answers choose for the same clauses."""
    chosen = [
        {
            (node, key)
            for node, grounding in body["groundings"].items()
            for key in _chosen(grounding)
        }
        for body in bodies
    ]
    every: set[tuple[str, Key]] = set().union(*chosen)
    return {key for node, key in every if any((node, key) not in one for one in chosen)}


def _all_keys(bodies: Iterable[Record]) -> list[Key]:
    """Return answers' choices for any clause, each once, in the order of the answers."""
    groundings = (grounding for body in bodies for grounding in body["groundings"].values())
    return list(dict.fromkeys(key for grounding in groundings for key in _chosen(grounding)))


def _drawn(
    scene: Scene,
    video: str | None,
    keys: Sequence[Key],
    shown: Mapping[Key, str],
    disputed: Collection[Key],
) -> Picture:
    """Return a scene with answers' choices; on those in `disputed` the answers differ."""
    size = scene.segmentation.get("width", 0), scene.segmentation.get("height", 0)

    def outline(key: Key, polygons: Sequence[Sequence[Sequence[float]]]) -> Outline:
        points = tuple(map(_svg_points, polygons))
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


def _svg_points(corners: Iterable[Sequence[float]]) -> str:
    return " ".join(f"{x:.2f},{y:.2f}" for x, y in corners)
