"""What the dashboard counts in indexes is what all answers say, read one by one."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from dataclasses import asdict, replace
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

import numpy as np
import pytest
from flask import Flask
from hypothesis import given
from hypothesis import strategies as st
from sqlalchemy import select, update
from sqlalchemy.orm import Session

from annotation_app.core.config import Config
from annotation_app.core.random_ids import new_id
from annotation_app.dashboard import workers as people
from annotation_app.dashboard.consensus import agreement
from annotation_app.dashboard.study_statistics import (
    collected,
    durations,
    histories,
    progress_by_video,
)
from annotation_app.dashboard.workers import median_of_others, workers
from annotation_app.items.new_items import new_slots
from annotation_app.people.participants import subject_of
from annotation_app.store.database import opened, reading, transaction
from annotation_app.store.models import Answer, Event, Item, Person, Record, Study
from annotation_app.store.schema import migrate
from annotation_app.tasks.agreement import FEWEST_ITEMS, figures
from annotation_app.tasks.task_registry import task_names, task_of, tasks
from annotation_app.work.answer_flags import answer_flags, odd_below
from annotation_app.work.answer_reading import gist_of
from tests.annotation_app.browser import Browser, engine_of, execute, installation_of, row_in
from tests.annotation_app.dashboard.test_pages import ONE, dispute, sdcs
from tests.annotation_app.old_installations import old_installation

NOW = 1000.0
KINDS = "usual", "usual", "usual", "attention", "adjudicated"


class Row(NamedTuple):
    answer: Answer
    item: Item
    event: Event


def body_of(task: str, rng: np.random.Generator) -> Record:
    watched = {"watched_s": round(float(rng.uniform(0, 20)), 2), "speed": float(rng.choice([1, 2]))}
    if task == "rate":
        return {"rating": int(rng.integers(1, 6)), **watched}
    if task == "check":
        long = {str(n): True for n in range(10, 200)} if rng.random() < 0.1 else {}
        said = {str(n): [True, False, "cant_tell"][rng.integers(3)] for n in range(2)}
        return {"verdicts": {**said, **long}, **watched}
    return {"text": str(rng.choice(["Go.", "go", "Take it to the truck."])), **watched}


def fill(session: Session, seed: int) -> str:
    """A study with answers of all sorts; its id."""
    rng = np.random.default_rng(seed)
    study = Study(id=new_id(), name=f"study-{seed}", config={}, created_at=NOW)
    persons = [
        Person(
            id=new_id(), role="worker", provider="open", external_hash=new_id(), profile={},
            created_at=NOW,
        )
        for _ in range(6)
    ]  # fmt: skip
    session.add_all([study, *persons])
    session.flush()
    for number in range(40):
        task = ["describe", "rate", "check", "check", "gone"][rng.integers(5)]
        kind = str(rng.choice(KINDS))
        is_check = kind == "attention" and task == "rate"
        payload = {"text": "Go to the truck.", "video": f"v{number % 3}"[: number % 4]}
        item = Item(
            id=new_id(), study_id=study.id, task=task, subject=str(number), rank=0.0,
            payload={**payload, "right": bool(rng.integers(2))} if is_check else payload,
            attention=is_check,
        )  # fmt: skip
        item.slots = new_slots(item, 2)
        item.slots[0].person_id, item.slots[0].expires_at = persons[0].id, NOW + rng.integers(-1, 2)
        item.slots[1].answered = bool(rng.integers(2))
        session.add(item)
        session.flush()
        for person in rng.permutation(np.array(persons))[: rng.integers(7)]:
            _add(session, rng, item, person, "adjudicated" if kind == "adjudicated" else "usual")
    return study.id


def _add(session: Session, rng: np.random.Generator, item: Item, person: Person, kind: str) -> None:
    body = body_of(item.task, rng)
    name = "adjudicate" if kind == "adjudicated" else "submit"
    at = float(rng.uniform(0, 500))
    event = Event(uuid=new_id(), item_id=item.id, person_id=person.id, name=name, body=body, at=at)
    session.add(event)
    session.flush()
    shown = {"suggestion": "shown", "unchanged": True, "likeness": 1.0}
    provenance = shown if item.task == "check" and rng.random() < 0.2 else None
    session.add(
        Answer(
            item_id=item.id, study_id=item.study_id, person_id=person.id, task=item.task,
            kind="attention" if item.attention else kind, subject=item.subject, event_id=event.id,
            body=body, gist=gist_of(item.task, body), surplus=bool(rng.random() < 0.2),
            adopted=bool(rng.random() < 0.5), excluded=bool(rng.random() < 0.2),
            seconds=None if rng.random() < 0.1 else round(float(rng.lognormal(2)), 3),
            odd_below_s=odd_below(item.payload, body, provenance), provenance=provenance, at=at,
        )
    )  # fmt: skip
    session.flush()


def views(session: Session, study: str) -> dict[str, Any]:
    return {
        "progress": progress_by_video(session, study, now=NOW),
        "durations": durations(session, study),
        "histories": histories(session, study, now=NOW),
        "collected": collected(session, study),
        "workers": workers(session, study),
        "agreement": agreement(session, study),
    }


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_counts_are_those_of_all_answers(config: Config) -> None:
    with opened(config.database) as engine:
        migrate(engine)
        with transaction(engine) as session:
            studies = [fill(session, seed) for seed in range(4)]
        with reading(engine, one_state=True) as session:
            found = [views(session, study) for study in studies]
            for study, view in zip(studies, found, strict=True):
                rows = [
                    Row(*row)
                    for row in session.execute(
                        select(Answer, Item, Event)
                        .join(Item, Item.id == Answer.item_id)
                        .join(Event, Event.id == Answer.event_id)
                        .where(Item.study_id == study)
                        .order_by(Answer.id)
                    )
                ]
                assert len(rows) > 50
                _check_times(view, rows)
                _check_counts(view, rows)
                _check_agreement(view, rows)
                _check_people(view, rows, session)
        # Answers of which nothing is known beforehand are read.
        execute(engine, update(Answer).values(gist=None, odd_below_s=None))
        with reading(engine, one_state=True) as session:
            for study, view in zip(studies, found, strict=True):
                again = views(session, study)
                assert {**again, "agreement": 0} == {**view, "agreement": 0}
                _check_agreement(again, rows if study == studies[-1] else [])


def _check_times(view: Record, rows: list[Row]) -> None:
    for one in view["durations"]:
        seconds = [
            a.seconds for a, _, _ in rows
            if a.task == one.task and not a.excluded and a.seconds is not None
        ]  # fmt: skip
        quartiles = tuple(np.percentile(seconds, (25, 50, 75)).tolist())
        assert (one.lower_s, one.median_s, one.upper_s) == quartiles
        assert one.answers == len(seconds)
    assert [one.task for one in view["durations"]] == ["describe", "check", "rate"]
    counting = [a for a, i, _ in rows if not i.attention and not a.excluded]
    at = np.linspace(min(a.at for a in counting), NOW, 40)
    for one in view["histories"]:
        times = np.sort([a.at for a in counting if a.task == one.task])
        assert one.at == tuple(at.tolist())
        assert one.answers == tuple(np.searchsorted(times, at, side="right").tolist())


def _check_counts(view: Record, rows: list[Row]) -> None:
    wanted: Record = {}
    for task in tasks():
        if task.counts is not None:
            counted = [
                (a.body, a.adopted) for a, i, _ in rows
                if a.task == task.name and not i.attention and not a.excluded
            ]  # fmt: skip
            wanted |= asdict(task.counts.of(counted))
    wanted["annotators"] = len({a.person_id for a, _, _ in rows})
    wanted["surplus"] = sum(
        a.surplus and e.name != "adjudicate" and not i.attention and not a.excluded
        for a, i, e in rows
    )
    assert view["collected"] == wanted


def _check_agreement(view: Record, rows: list[Row]) -> None:
    if not rows:
        return
    for task in tasks():
        items: dict[str, list[Record]] = defaultdict(list)
        for a, i, e in rows:
            if (a.task, i.attention, a.excluded) == (task.name, False, False):
                items[a.item_id] += [a.body] if e.name != "adjudicate" else []
        answered = [bodies for bodies in items.values() if bodies]
        compared = [
            [one.units([*map(one.read, bodies)]) for one in task.agreement]
            for bodies in answered
            if len(bodies) > 1
        ]
        several = len(compared)
        measures = figures(task.agreement, compared) if answered else ()
        wanted = [replace(m, task=task.name, items=several) for m in measures]
        found = [m for m in view["agreement"] if m.task == task.name and m.answers == "all"]
        for one, other in zip(found, wanted, strict=True):
            if several < FEWEST_ITEMS:
                assert one.value is None
                continue
            assert replace(one, value=None, low=None, high=None) == replace(other, value=None)
            assert one.value == pytest.approx(other.value, abs=1e-12)


def _check_people(view: Record, rows: list[Row], session: Session) -> None:
    seconds: dict[tuple[str, str], list[float]] = defaultdict(list)
    for a, _, _ in rows:
        if a.seconds is not None and a.task in task_names():
            seconds[a.person_id, a.task].append(a.seconds)
    assert {one.person_id for one in view["workers"]} == {a.person_id for a, _, _ in rows}
    for one in view["workers"]:
        mine = [(a, i) for a, i, _ in rows if a.person_id == one.person_id]
        checks = [task_of("rate").passes(i.payload, a.body) for a, i in mine if i.attention]  # type: ignore[misc]
        assert one.subject == subject_of(session.get_one(Person, one.person_id))
        assert (one.answers, one.checks) == (len(mine), len(checks))
        assert one.failed == checks.count(False)
        medians = {task: median(s) for (who, task), s in seconds.items() if who == one.person_id}
        assert one.median_s == medians
        flags = Counter(
            flag
            for a, i in mine
            for flag in answer_flags(i.payload, a.body, a.provenance, a.seconds)
        )
        often = {flag: n for flag, n in flags.items() if n >= people.FEWEST_FLAGS[flag]}
        said = [reason.partition(":") for reason in one.reasons]
        assert {flag: int(n.split()[0]) for flag, _, n in said if flag in flags} == often
        for task, usual in medians.items():
            others = [
                median(s) for (who, t), s in seconds.items() if t == task and who != one.person_id
            ]
            is_fast = (
                len(seconds[one.person_id, task]) >= people.FEWEST and usual < median(others) / 3
            )
            assert any(f"item of {task}," in reason for reason in one.reasons) == is_fast


def test_what_is_kept_beside_answers(app: Flask, tmp_path: Path) -> None:
    """As people send them, as somebody decides, and as they are in an older installation."""
    dispute(app)
    rater, judge = Browser(app), Browser(app, "adjudicator")
    for _ in range(3):
        page = rater.take("rate")
        rater.answer(page["item"], {"rating": 4, "watched_s": 900.0})
    item = row_in(app, select(Item.id).where(Item.task == "segment"))
    assert judge.adjudicate(item, sdcs(ONE)).status_code == 200
    old = old_installation(installation_of(app).config, tmp_path / "old")
    with opened(old.database) as engine:
        migrate(engine)
        with reading(engine_of(app)) as session, reading(engine) as other:
            _check_columns(session, is_filled=False)
            _check_columns(other, is_filled=True)


def _check_columns(session: Session, *, is_filled: bool) -> None:
    rows = session.execute(
        select(Answer, Item, Event.name)
        .join(Item, Item.id == Answer.item_id)
        .join(Event, Event.id == Answer.event_id)
    ).all()
    kinds = {"submit": "usual", "adjudicate": "adjudicated"}
    for answer, item, event in rows:
        assert answer.study_id == item.study_id
        assert answer.kind == ("attention" if item.attention else kinds[event])
        if not is_filled or answer.task == "rate":
            assert answer.gist == gist_of(answer.task, answer.body)
        enough = odd_below(item.payload, answer.body, answer.provenance)
        assert enough is not None
        assert answer.odd_below_s is not None
        assert answer.odd_below_s >= enough if is_filled else answer.odd_below_s == enough
    assert {answer.kind for answer, _, _ in rows} == {"usual", "attention", "adjudicated"}
    assert any(answer.gist for answer, _, _ in rows)


@given(st.lists(st.floats(0, 1e3), min_size=1, max_size=9), st.data())
def test_the_median_of_others(seconds: list[float], data: st.DataObject) -> None:
    own = data.draw(st.sampled_from(seconds))
    others = [*seconds]
    others.remove(own)
    assert median_of_others(sorted(seconds), own) == (median(others) if others else None)


@given(
    st.text("ab ", max_size=20),
    st.floats(0, 1e6),
    st.floats(0, 4, exclude_min=True),
    st.booleans(),
    st.floats(0, 1e7),
)
def test_answers_that_took_long_enough_are_not_odd(
    command: str, watched_s: float, speed: float, unchanged: bool, longer_s: float
) -> None:
    payload, body = {"text": command}, {"watched_s": watched_s, "speed": speed}
    provenance = {"suggestion": "shown", "unchanged": unchanged}
    enough = odd_below(payload, body, provenance)
    if enough is not None:
        assert math.isfinite(enough)
        assert [*answer_flags(payload, body, provenance, enough + longer_s)] == []
