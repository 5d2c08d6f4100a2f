"""Things that people draw while they ground a command, where nobody had marked them.

What is drawn belongs to an answer. A thing that another answer to the item has drawn already, at
the same place, has the same id, so that such answers agree.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, TypeAlias

import msgspec
from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.core.languages import gettext
from annotation_app.core.problems import FieldProblem
from annotation_app.items.assignment import AnyItem
from annotation_app.items.scenes import Scene
from annotation_app.store.models import Answer, Record, Study
from annotation_app.tasks.watched_videos import Seconds

SAME_PART = 0.5
"""Least part of the union of two boxes that both have, if they are of the same thing."""
SAME_S = 0.5
"""Largest difference of the moments of two drawings of the same thing, in seconds."""
SMALLEST_PX = 2.0


MOST_DRAWN = 50
Coordinate: TypeAlias = Annotated[float, msgspec.Meta(ge=-1e6, le=1e6)]
Polygon: TypeAlias = Annotated[
    list[tuple[Coordinate, Coordinate]], msgspec.Meta(min_length=3, max_length=200)
]


class DrawnThing(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A thing that somebody has drawn, in pixels of the picture."""

    id: Annotated[str, msgspec.Meta(pattern=r"^drawn-[\w-]{1,40}$")]
    polygons: Annotated[list[Polygon], msgspec.Meta(min_length=1, max_length=20)]
    time_s: Seconds = 0.0


def lets_draw(session: Session, study_id: str) -> bool:
    """Check that a study lets people draw things in Ground."""
    study = session.get(Study, study_id)
    config: Mapping[str, Any] = study.config if study is not None else {}
    return bool(config.get("tasks", {}).get("ground", {}).get("drawing"))


def may_draw(session: Session, item: AnyItem, scene: Scene) -> bool:
    """Check that people may draw things in an item's picture."""
    return scene.is_picture and lets_draw(session, item.study_id)


def recognised(
    session: Session,
    item: AnyItem,
    drawn: Sequence[DrawnThing],
    scene: Scene,
    problems: list[FieldProblem],
) -> dict[str, Record]:
    """Return what was drawn as answers keep it, by the ids that were sent.

    Faults are added to `problems`.
    """
    bodies = session.scalars(select(Answer.body).where(Answer.item_id == item.id))
    known = [one for body in bodies for one in body.get("drawn", [])]
    size = scene.segmentation.get("width", 0), scene.segmentation.get("height", 0)
    found: dict[str, Record] = {}
    for one in drawn:
        box = _box(one.polygons)
        if min(box[2:]) < SMALLEST_PX or min(box[:2]) < -1 or _is_outside(box, size):
            text = gettext("Something that was drawn isn't in the picture. Draw it again.")
            problems.append(FieldProblem("drawn", text))
            continue
        polygons = [[list(corner) for corner in polygon] for polygon in one.polygons]
        content = {"time_s": one.time_s, "box": box, "polygons": polygons}
        alike = (other["id"] for other in known if _is_same(other, content))
        digest = hashlib.sha256(msgspec.json.encode(content)).hexdigest()[:12]
        found[one.id] = {"id": next(alike, f"drawn-{digest}"), **content}
    return found


def sent_thing(kept: Record) -> Record:
    """Return a drawn thing as people's pages send it."""
    return {name: kept[name] for name in ("id", "polygons", "time_s")}


def marked_things(body: Record, grounding: Record) -> list[str]:
    """Return the things of a grounding but those that its answer has drawn."""
    drawn = {one["id"] for one in body.get("drawn", [])}
    return [name for name in grounding["objects"] if name not in drawn]


def _box(polygons: Sequence[Sequence[tuple[float, float]]]) -> list[float]:
    corners = [corner for polygon in polygons for corner in polygon]
    (x, u), (y, v) = ((min(values), max(values)) for values in zip(*corners, strict=True))
    return [x, y, u - x, v - y]


def _is_outside(box: Sequence[float], size: tuple[int, int]) -> bool:
    """Check that a box leaves a picture whose size is known."""
    x, y, width, height = box
    return bool(all(size)) and (x + width > size[0] + 1 or y + height > size[1] + 1)


def _is_same(one: Record, other: Record) -> bool:
    if abs(one["time_s"] - other["time_s"]) > SAME_S:
        return False
    shared = 1.0
    for axis in (0, 1):
        starts = (one["box"][axis], other["box"][axis])
        ends = (start + of["box"][axis + 2] for start, of in zip(starts, (one, other), strict=True))
        shared *= max(0.0, min(ends) - max(starts))
    areas = sum(of["box"][2] * of["box"][3] for of in (one, other))
    return bool(shared >= SAME_PART * (areas - shared))
