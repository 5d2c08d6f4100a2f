"""Errors of the models that proposed steps, by what people made of their proposals.

Intervals are those of the bootstrap over episodes (percentiles), since the steps of an episode have
their faults in common. Answers of people who saw no proposal are compared with it too, and
reported apart: people who correct a proposal tend to keep it.

``accepted``, ``text changed``, ``boundary moved`` and ``removed`` are shares of the proposed steps,
``added`` is the number of new steps for each of them. ``text edit distance`` is the mean, and
``boundary error`` the median, over the steps that weren't removed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import IO, Literal, TypeAlias

import msgspec
import numpy as np
import numpy.typing as npt
from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.people.participants import subject_of
from annotation_app.store.models import Answer, Item, Person, Record, Study, TaskName
from annotation_app.tasks.agreement import FEWEST_ITEMS, Measured, ModelErrors
from annotation_app.tasks.proposed_steps import ADDED, BOTH, BOUNDARY, REMOVED, TEXT, UNCHANGED
from annotation_app.tasks.task_record import AnswerTable, write_csv
from corpus_tools.corpus.estimate import Reason

DRAWS = 1000
SEED = 0

Floats: TypeAlias = npt.NDArray[np.float64]
Weights: TypeAlias = npt.NDArray[np.int64]
"""Number of times that each episode counts, shape (draws, episodes)."""


def model_errors(session: Session, study: Study) -> list[ModelErrors]:
    """Return the errors of each model, first against people who saw its proposals."""
    compared: dict[tuple[str, bool], list[tuple[str, Record]]] = {}
    for answer, item, _ in _compared(session, study):
        provenance = answer.provenance or {}
        fates = provenance["fates"]
        is_shown = provenance["suggestion"] == "shown"
        compared.setdefault((fates["source"], is_shown), []).append((item.id, fates))
    return [
        _errors(source, "shown" if is_shown else "not shown", compared[source, is_shown])
        for source, is_shown in sorted(compared, key=lambda key: (key[0], not key[1]))
    ]


def _compared(session: Session, study: Study) -> Iterator[tuple[Answer, Item, Person]]:
    """Yield the answers that are compared with proposals."""
    rows = session.execute(
        select(Answer, Item, Person)
        .join(Item, Item.id == Answer.item_id)
        .join(Person, Person.id == Answer.person_id)
        .where(
            Item.study_id == study.id,
            Item.task == TASK,
            Item.attention.is_(False),
            Answer.excluded.is_(False),
        )
        .order_by(Answer.id)
        .execution_options(yield_per=500)
    )
    for answer, item, person in rows:
        if (answer.provenance or {}).get("fates"):
            yield answer, item, person


TASK: TaskName = "subtasks"


def _errors(
    source: str, proposal: Literal["shown", "not shown"], answers: Sequence[tuple[str, Record]]
) -> ModelErrors:
    items = list(dict.fromkeys(item for item, _ in answers))
    place = {item: number for number, item in enumerate(items)}
    steps = [(place[item], step) for item, fates in answers for step in fates["steps"]]
    kept = [(n, step) for n, step in steps if step["state"] != REMOVED]
    moved = [(n, abs(step["moved_s"])) for n, step in kept if step["moved_s"] is not None]
    added = [(place[item], len(fates["added"])) for item, fates in answers]

    def by_item(rows: Sequence[tuple[int, float]]) -> Floats:
        total = np.zeros(len(items))
        for number, value in rows:
            total[number] += value
        return total

    whole = by_item([(n, 1) for n, _ in steps])

    def share(*states: str) -> Floats:
        return by_item([(n, step["state"] in states) for n, step in steps])

    ratios = {
        "accepted": (share(UNCHANGED), whole),
        "text changed": (share(TEXT, BOTH), whole),
        "boundary moved": (share(BOUNDARY, BOTH), whole),
        "removed": (share(REMOVED), whole),
        "added": (by_item(added), whole),
        "text edit distance": (
            by_item([(n, step["text_distance"]) for n, step in kept]),
            by_item([(n, 1) for n, _ in kept]),
        ),
    }
    weights = np.random.default_rng(SEED).multinomial(
        len(items), np.full(len(items), 1 / len(items)), DRAWS
    )
    measures = [
        _bounded(name, partial(_ratio, some=some, of=of), weights)
        for name, (some, of) in ratios.items()
    ]
    numbers = np.array([n for n, _ in moved], dtype=np.int64)
    seconds = np.array([s for _, s in moved])
    for name, chosen in (
        ("boundary error, s", seconds >= 0),
        ("boundary error where moved, s", seconds > 0),
    ):
        median = partial(_medians, of=numbers[chosen], values=seconds[chosen])
        measures.append(_bounded(name, median, weights))
    undecided = sum(not step["decided"] for _, step in steps) if proposal == "shown" else 0
    return ModelErrors(
        TASK, source, proposal, len(items), len(answers), len(steps), undecided, tuple(measures)
    )


def _bounded(name: str, figure: Callable[[Weights], Floats], weights: Weights) -> Measured:
    """Measure a figure and its interval over draws of episodes, shape (draws, episodes)."""
    items = weights.shape[1]
    [value] = figure(np.ones((1, items), np.int64))
    if np.isnan(value):
        return Measured(name, None, items, reason="no data", items=items)
    reason: Reason = "few clusters" if items < FEWEST_ITEMS else ""
    found = Measured(name, float(value), items, reason=reason, items=items)
    drawn = figure(weights) if not reason else np.array([])
    drawn = drawn[~np.isnan(drawn)]
    if len(drawn) < 0.95 * DRAWS or drawn.min() == drawn.max():
        return found
    low, high = np.quantile(drawn, (0.025, 0.975))
    return replace(found, low=float(low), high=float(high))


def _ratio(weights: Weights, some: Floats, of: Floats) -> Floats:
    """Return the ratio of two sums over weighted episodes, for each row of weights."""
    whole: Floats = weights @ of
    result = np.full(len(weights), np.nan)
    np.divide(weights @ some, whole, out=result, where=whole > 0)
    return result


def _medians(weights: Weights, of: npt.NDArray[np.int64], values: Floats) -> Floats:
    """Return the median of the weighted episodes' values; `of` has the episode of each value."""
    order = np.argsort(values)
    result = np.full(len(weights), np.nan)
    for row, counts in enumerate(weights[:, of[order]]):
        total = np.cumsum(counts)
        if len(total) and total[-1]:
            middle = [(total[-1] - 1) // 2, total[-1] // 2]
            result[row] = values[order][np.searchsorted(total, middle, side="right")].mean()
    return result


def errors_to_csv(session: Session, study: Study, file: IO[bytes]) -> None:
    """Write a row for each model, group of answers and measure."""
    columns = (
        "study", "model", "proposal", "episodes", "answers", "steps", "undecided", "measure",
        "value", "low", "high", "reason",
    )  # fmt: skip
    rows = (
        (
            *(study.name, row.source, row.proposal, row.items, row.answers, row.parts),
            *(row.undecided, one.measure, one.value, one.low, one.high, one.reason),
        )
        for row in model_errors(session, study)
        for one in row.measures
    )
    write_csv(file, columns, rows)


def errors_to_json(session: Session, study: Study, file: IO[bytes]) -> None:
    """Write the same as JSON."""
    content = {"study": study.name, "models": model_errors(session, study)}
    file.write(msgspec.json.format(msgspec.json.encode(content)) + b"\n")


def steps_to_csv(session: Session, study: Study, file: IO[bytes]) -> None:
    """Write a row for each proposed step in each answer, and for each step that was added."""
    columns = (
        "answer", "video", "subject", "model", "suggestion", "state", "decided", "proposed_s",
        "proposed", "start_s", "text", "moved_s", "text_distance",
    )  # fmt: skip
    write_csv(file, columns, _step_rows(session, study))


def _step_rows(session: Session, study: Study) -> Iterator[tuple[object, ...]]:
    for answer, item, person in _compared(session, study):
        provenance, steps = answer.provenance or {}, answer.body["subtasks"]
        fates = provenance["fates"]
        about = (
            *(answer.id, item.payload["video"], subject_of(person)),
            *(fates["source"], provenance["suggestion"]),
        )
        for fate in fates["steps"]:
            kept = steps[fate["step"]] if fate["step"] is not None else {}
            yield (
                *about, fate["state"], fate["decided"], round(fate["start_s"], 3), fate["text"],
                kept.get("start_s"), kept.get("text"), fate.get("moved_s"),
                fate.get("text_distance"),
            )  # fmt: skip
        for number in fates["added"]:
            step = steps[number]
            yield (*about, ADDED, True, None, None, step["start_s"], step["text"], None, None)


TABLES = {
    "model-errors.csv": AnswerTable("Errors of models (CSV)", "text/csv", errors_to_csv),
    "model-errors.json": AnswerTable("Errors of models (JSON)", "application/json", errors_to_json),
    "proposed-steps.csv": AnswerTable("Proposed steps (CSV)", "text/csv", steps_to_csv),
}
"""Files about the models that proposed steps."""
