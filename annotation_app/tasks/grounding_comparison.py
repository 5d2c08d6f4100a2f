"""Answers to a grounding beside each other: what they share, and in what they differ."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import msgspec
from sqlalchemy.orm import Session

from annotation_app.items.item_scenes import aliases_of
from annotation_app.items.media import media_files
from annotation_app.items.scenes import scene_payload
from annotation_app.store.models import Item, Record
from annotation_app.tasks.agreement import AREA, CLAUSE_TYPE, PLACE, THING, WORDS, Key, Part
from annotation_app.tasks.clause_words import HAPPENING, clauses_of
from annotation_app.tasks.grounding_pictures import draw
from annotation_app.tasks.task_record import Compared
from g3.sdc.clauses import SDC, breadth_first
from g3.sdc.sdc_notation import from_json


@dataclass(frozen=True, slots=True)
class Choice:
    """Something that an answer says of a clause.

    Parameters
    ----------
    text
        In words.
    shown
        What the worker's page calls the thing or place; empty for all else.
    differs
        Whether another answer doesn't say so.
    """

    text: str
    shown: str
    differs: bool


@dataclass(frozen=True, slots=True)
class ComparedClause:
    """A clause: what each answer says of it, in the order of the answers."""

    node: int
    phrase: str
    choices: tuple[tuple[Choice, ...], ...]
    times: tuple[tuple[float, float], ...]
    """For an EVENT or a PATH, the part of the video by each answer, in percent of it."""

    @property
    def differs(self) -> bool:
        """Whether the answers don't all say the same."""
        return any(choice.differs for choices in self.choices for choice in choices)


def grounding_key(grounding: Record) -> bytes:
    """What two groundings of a clause must share to be the same."""
    return msgspec.json.encode(
        (sorted(grounding["objects"]), grounding["places"], grounding["cant_tell"])
    )


def essence(body: Record) -> Any:
    """What two answers must share to agree: all but how long people took."""
    return body["trims"], {node: grounding_key(g) for node, g in body["groundings"].items()}


def shared_part(one: Record, other: Record) -> float:
    """The part of the clauses that two answers ground alike."""
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
    """What each clause was grounded to, and a picture of all of it, with what differs marked."""
    video = item.payload["video"]
    scene, names = aliases_of(session, item, video, salt)
    shown: Mapping[Key, str] = {
        **{(THING, real): alias for alias, real in names.objects.items()},
        **{(PLACE, index): alias for alias, index in names.places.items()},
    }
    files = media_files(session, item.study_id, video).public
    clauses = list(_clauses(item, bodies, scene.duration_s, shown))
    picture = draw(scene, files.get("video"), _all_keys(bodies), shown, _disputed_keys(bodies))
    about = {"clauses": clauses, "picture": picture, "scene": scene_payload(scene, names, files)}
    return Compared(tuple(range(len(bodies))), about)


def disputed_parts(item: Item, bodies: Sequence[Record]) -> Iterator[Part]:
    """The clauses of a command, their words, and the things and places that people chose."""
    sdcs = _nodes(item)
    for clause in clauses_of(from_json(item.payload["sdcs"])):
        said = [_said(body, str(clause["node"]), sdcs[clause["node"]]) for body in bodies]
        differs = len(set(said)) > 1
        yield Part(CLAUSE_TYPE, clause["type"], differs)
        yield Part(WORDS, clause["phrase"].lower(), differs)
        for kind, what in dict.fromkeys(key for keys in said for key in keys):
            if kind in (THING, PLACE):
                in_all = all((kind, what) in keys for keys in said)
                yield Part(kind, str(what), not in_all, item.payload["video"])


def _nodes(item: Item) -> list[SDC]:
    return list(breadth_first(from_json(item.payload["sdcs"])))


def _clauses(
    item: Item, bodies: Sequence[Record], duration_s: float, shown: Mapping[Key, str]
) -> Iterator[ComparedClause]:
    sdcs = _nodes(item)
    for clause in clauses_of(from_json(item.payload["sdcs"])):
        sdc, node = sdcs[clause["node"]], str(clause["node"])
        said = [_said(body, node, sdc) for body in bodies]
        times: tuple[tuple[float, float], ...] = ()
        if sdc.type in HAPPENING:
            parts = (body["trims"].get(node, (0.0, duration_s)) for body in bodies)
            whole = max(duration_s, 0.1)
            times = tuple(
                (100 * start / whole, 100 * (end - start) / whole) for start, end in parts
            )
        choices = tuple(
            tuple(
                Choice(_words(key), shown.get(key, ""), any(key not in other for other in said))
                for key in keys
            )
            for keys in said
        )
        yield ComparedClause(clause["node"], clause["phrase"], choices, times)


def _said(body: Record, node: str, sdc: SDC) -> tuple[Key, ...]:
    """What an answer says of a clause."""
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


def _words(key: Key) -> str:
    kind, what = key
    if kind == THING:
        return str(what)
    if kind == PLACE:
        return f"place {what} of the map"
    if kind == AREA:
        xs, ys = zip(*what, strict=True)
        return f"area around ({sum(xs) / len(xs):.1f}, {sum(ys) / len(ys):.1f}) m"
    if kind == "time":
        return "the whole video" if what is None else f"{what[0]:.1f} to {what[1]:.1f} s"
    return kind


def _disputed_keys(bodies: Sequence[Record]) -> set[Key]:
    """The things, places and areas that not all answers choose for the same clauses."""
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
    """What answers choose for any clause, each once, in the order of the answers."""
    groundings = (grounding for body in bodies for grounding in body["groundings"].values())
    return list(dict.fromkeys(key for grounding in groundings for key in _chosen(grounding)))
