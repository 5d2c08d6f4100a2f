"""Adopted groundings as a table: also those in pictures, of which no corpus can be made."""

from __future__ import annotations

from collections.abc import Iterator
from typing import IO

import msgspec
from sqlalchemy.orm import Session

from annotation_app.items.item_scenes import scene_of
from annotation_app.items.scenes import Scene
from annotation_app.store.models import Record, Study
from annotation_app.tasks.clause_words import clauses_of
from annotation_app.tasks.corpus_parts import answers_of
from annotation_app.tasks.csv_rows import write_csv
from g3.sdc.sdc_notation import from_json

COLUMNS = (
    "answer", "command", "video", "clause", "type", "phrase", "things", "labels", "boxes", "places",
    "cant_tell", "from_s", "to_s",
)  # fmt: skip


def write_groundings(session: Session, study: Study, file: IO[bytes]) -> None:
    """A row for each clause that an adopted answer grounds.

    ``things`` are ids: of annotations, if the things come from a COCO file. ``boxes`` are x, y,
    width and height in pixels of the picture.
    """
    write_csv(file, COLUMNS, _rows(session, study))


def _rows(session: Session, study: Study) -> Iterator[tuple[object, ...]]:
    for answer, item in answers_of(session, study, "ground", adopted=True):
        scene = scene_of(session, study.id, item.payload["video"])
        for clause in clauses_of(from_json(item.payload["sdcs"])):
            node = str(clause["node"])
            grounding = answer.body["groundings"].get(node)
            part = answer.body["trims"].get(node)
            if grounding is not None or part is not None:
                about = (answer.id, item.payload["text"], item.payload["video"], node)
                of = (clause["type"], clause["phrase"])
                yield (*about, *of, *_shown(grounding, scene), *(part or ("", "")))


def _shown(grounding: Record | None, scene: Scene) -> tuple[object, ...]:
    if grounding is None:
        return "", "", "", "", ""
    ids = grounding["objects"]
    labels = {thing.id: " ".join(thing.labels) for thing in scene.context.objects}
    boxes = {one["id"]: one["box"] for one in scene.segmentation.get("objects", [])}
    return (
        " ".join(ids),
        "; ".join(labels.get(one, "") for one in ids),
        _json([boxes.get(one) for one in ids]),
        _json(grounding["places"]),
        grounding["cant_tell"],
    )


def _json(value: object) -> str:
    return msgspec.json.encode(value).decode() if value else ""
