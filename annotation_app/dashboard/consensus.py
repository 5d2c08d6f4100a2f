"""How much a study's people agree, task by task."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, get_args

import msgspec
from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.store.models import Answer, Event, Item, Record, Task
from annotation_app.tasks.agreement import Measure, mean_pairwise
from corpus_tools.corpus.rater_agreement import Level, fleiss_kappa, krippendorff_alpha
from g3.sdc.sdc_notation import from_json


@dataclass(frozen=True, slots=True)
class Agreement:
    """A measure of agreement.

    Parameters
    ----------
    value
        None where too little has been answered twice, or everybody says the same all the time.
    units
        What was answered by two people or more: commands, clauses, pairs.
    """

    task: Task
    measure: str
    value: float | None
    units: int


def agreement(session: Session, study_id: str) -> list[Agreement]:
    """What can be measured so far, of all tasks that are answered by several people."""
    by_item = _bodies(session, study_id)
    trees = [[from_json(body["sdcs"]) for body in item] for item in by_item("segment")]
    found = []
    for measure in get_args(Measure):
        scored = mean_pairwise(trees, measure)
        value, pairs = scored or (None, 0)
        found.append(Agreement("segment", f"{measure} F, mean over pairs", value, pairs))
    found += _ratings("ground", _by_node(by_item("ground"), "groundings", _grounding))
    found += _ratings("check", _by_node(by_item("check"), "verdicts", str))
    ratings = [[body["rating"] for body in item] for item in by_item("rate")]
    found += _ratings("rate", ratings, ("ordinal", "interval"))
    return found


def _bodies(session: Session, study_id: str) -> Any:
    rows = session.execute(
        select(Answer.task, Answer.item_id, Answer.body)
        .join(Item, Item.id == Answer.item_id)
        .join(Event, Event.id == Answer.event_id)
        # Adjudicators have seen what the others answered.
        .where(Item.study_id == study_id, Item.attention.is_(False), Event.name != "adjudicate")
        .order_by(Answer.id)
    )
    found: dict[str, dict[str, list[Record]]] = {}
    for task, item_id, body in rows:
        found.setdefault(task, {}).setdefault(item_id, []).append(body)
    return lambda task: list(found.get(task, {}).values())


def _by_node(items: Iterable[list[Record]], part: str, value: Any) -> Iterator[list[Hashable]]:
    for bodies in items:
        for node in dict.fromkeys(node for body in bodies for node in body[part]):
            yield [value(body[part][node]) for body in bodies if node in body[part]]


def _grounding(grounding: Record) -> Hashable:
    shown = sorted(grounding["objects"]), grounding["places"], grounding["cant_tell"]
    return msgspec.json.encode(shown)


def _ratings(
    task: Task, units: Iterable[list[Any]], levels: tuple[Level, ...] = ("nominal",)
) -> list[Agreement]:
    rated = [unit for unit in units if len(unit) > 1]
    found = [
        Agreement(task, f"Krippendorff's α, {level}", krippendorff_alpha(rated, level), len(rated))
        for level in levels
    ]
    return [*found, Agreement(task, "Fleiss' κ", fleiss_kappa(rated), len(rated))]
