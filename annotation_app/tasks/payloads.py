"""What a page is told of an item, and nothing beyond it.

``Item.payload`` is what the server knows, by real names:

describe
    ``{"video"}``
segment
    ``{"video", "text", "command": id of the answer}``, and ``"suggestion"``: SDCs, if the
    command came with some
ground
    ``{"video", "text", "command", "sdcs"}``
check
    ``{"video", "text", "command", "sdcs", "grounding": id of the answer, "shown": {node:
    {"video", "objects": [ids], "places": [indices]}}}``
rate
    ``{"video": the one shown, "own_video", "text", "command", "right": True, False or None}``
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from sqlalchemy import and_, bindparam, select
from sqlalchemy.orm import Session

from annotation_app.store.models import Draft, Item, Record
from annotation_app.studies.suggestions import suggest
from annotation_app.tasks.assignment import AnyItem
from annotation_app.tasks.media import Files, media_files
from annotation_app.tasks.scenes import Aliases, Scene, aliases, read_scene, scene_payload
from g3.sdc.clauses import SDC, all_words, breadth_first
from g3.sdc.sdc_notation import from_json

WORD = re.compile(r"\w+(?:[-'’]\w+)*|[^\w\s]")


_ITEM = (
    select(Item, Draft)
    .outerjoin(Draft, and_(Draft.item_id == Item.id, Draft.person_id == bindparam("who")))
    .where(Item.id == bindparam("item"))
)


def page_data(session: Session, item_id: str, who: str, salt: bytes) -> Record:
    """What an item's page gets: ``item``, ``task``, ``draft`` and ``payload``.

    Payloads by task: describe ``video, poster, duration_s``; segment ``command, words,
    suggestion``; ground ``command, sdcs, clauses`` and what
    :func:`annotation_app.tasks.scenes.scene_payload` tells of the scene; check ``command, sdcs,
    scenes`` and ``clauses``, each with ``shown: {scene: index, objects, places}`` (a clause
    that is grounded to what happens has neither objects nor places: the scene's video is
    it); rate ``command, video, poster, duration_s``.
    """
    item, draft = session.execute(_ITEM, {"item": item_id, "who": who}).one()
    return {
        "item": item.id,
        "task": item.task,
        "draft": None if draft is None else {"revision": draft.revision, "body": draft.body},
        "payload": _PAYLOADS[item.task](session, item, salt),
    }


def scene_of(session: Session, study_id: str, video: str) -> Scene:
    """The world of a video."""
    return _shown(media_files(session, study_id, video), video)


def _shown(files: Files, video: str) -> Scene:
    return read_scene(files.paths["manifest"].parent, files.paths.get("corpus"), video)


def words_of(text: str) -> Iterator[dict[str, Any]]:
    """The words of a command and where each starts."""
    return ({"start": m.start(), "text": m[0]} for m in WORD.finditer(text))


def clauses_of(sdcs: tuple[SDC, ...]) -> list[Record]:
    """The clauses that words name: ``node`` (breadth first), ``type`` and ``phrase``."""
    return [
        {"node": node, "type": sdc.type, "phrase": " ".join(word.text for word in all_words(sdc))}
        for node, sdc in enumerate(breadth_first(sdcs))
        if not sdc.is_implicit
    ]


def aliases_of(session: Session, item: AnyItem, video: str, salt: bytes) -> tuple[Scene, Aliases]:
    """A video's world and what its things are called in an item."""
    scene = scene_of(session, item.study_id, video)
    return scene, aliases(scene, item.id, salt)


def _watched(session: Session, item: Item, _salt: bytes) -> Record:
    video = item.payload["video"]
    files = media_files(session, item.study_id, video)
    return {
        "video": files.public.get("video"),
        "poster": files.public.get("poster"),
        "duration_s": _shown(files, video).duration_s,
    }


def _rated(session: Session, item: Item, salt: bytes) -> Record:
    return {"command": item.payload["text"], **_watched(session, item, salt)}


def _segmented(_session: Session, item: Item, _salt: bytes) -> Record:
    text = item.payload["text"]
    return {
        "command": text,
        "words": list(words_of(text)),
        "suggestion": item.payload.get("suggestion") or suggest(text),
    }


def _grounded(session: Session, item: Item, salt: bytes) -> Record:
    video = item.payload["video"]
    scene, names = aliases_of(session, item, video, salt)
    sdcs = from_json(item.payload["sdcs"])
    return {
        "command": item.payload["text"],
        "sdcs": item.payload["sdcs"],
        "clauses": clauses_of(sdcs),
        **scene_payload(scene, names, media_files(session, item.study_id, video).public),
    }


def _checked(session: Session, item: Item, salt: bytes) -> Record:
    shown = item.payload["shown"]
    videos = list(dict.fromkeys(shown[node]["video"] for node in shown))
    worlds = {video: aliases_of(session, item, video, salt) for video in videos}
    clauses = []
    for clause in clauses_of(from_json(item.payload["sdcs"])):
        grounding = shown.get(str(clause["node"]))
        if grounding is None:
            continue
        names = worlds[grounding["video"]][1]
        objects = {real: alias for alias, real in names.objects.items()}
        places = {index: alias for alias, index in names.places.items()}
        found = {
            "scene": videos.index(grounding["video"]),
            "objects": [objects[real] for real in grounding["objects"]],
            "places": [places[index] for index in grounding["places"]],
        }
        clauses.append({**clause, "shown": found})
    return {
        "command": item.payload["text"],
        "sdcs": item.payload["sdcs"],
        "clauses": clauses,
        "scenes": [
            scene_payload(*worlds[video], media_files(session, item.study_id, video).public)
            for video in videos
        ],
    }


_PAYLOADS = {
    "describe": _watched,
    "segment": _segmented,
    "ground": _grounded,
    "check": _checked,
    "rate": _rated,
}
