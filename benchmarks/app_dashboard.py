"""Large studies: ``python -m benchmarks.app_dashboard``.

Studies of more and more answers are filled: each item of a video was rated by several people. The
processor time of the dashboard's pages and the memory of exports show how both grow. Each export is
made in a process of its own. PostgreSQL's own time doesn't count.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Callable, Mapping

import numpy as np
from sqlalchemy import func, insert, select
from sqlalchemy.orm import Session

from annotation_app.core.random_ids import new_id
from annotation_app.dashboard.adjudication_queue import disputes
from annotation_app.dashboard.answer_browsing import open_reports
from annotation_app.dashboard.consensus import agreement, disagreements
from annotation_app.dashboard.study_statistics import (
    at_work,
    collected,
    durations,
    forecast,
    histories,
    progress_by_video,
)
from annotation_app.dashboard.workers import workers
from annotation_app.export.answer_tables import TABLES
from annotation_app.items.assignment import still_open
from annotation_app.store.database import opened, reading, transaction
from annotation_app.store.models import Answer, Event, Handout, Item, Person, Slot, Study, queue_of
from annotation_app.store.schema import migrate
from annotation_app.studies.study_file import StudyConfig, TaskConfig, stored
from annotation_app.work.answer_flags import odd_below
from annotation_app.work.answer_reading import gist_of
from benchmarks.app_servers import new_databases
from benchmarks.timing import best, growth, in_own_process, most_mib, row

PER_ITEM, PER_PERSON, VIDEOS = 5, 200, 50
"""Answers to an item, and by a person."""
OPEN = 0.2
"""Share of the items that wait for one more answer."""
BEGIN = 1_700_000_000.0
"""A second before the first answer; one comes each second."""
OVERVIEW = (
    "progress by video", "times", "history", "collected", "people", "agreement", "at work",
    "forecast", "reports", "disputes",
)  # fmt: skip
"""The parts of the dashboard's first page."""
TITLES = {"sqlite": "SQLite", "postgresql": "PostgreSQL"}
EXPORTS = ("csv", "jsonl", "parquet", "reports.csv")


def fill(session: Session, answers: int, name: str = "load") -> str:
    """Add a study whose items have been rated by people, in bulk; return its id."""
    config = StudyConfig(name=name, title="Load", tasks={"rate": TaskConfig(answers=PER_ITEM)})
    study = new_id()
    about = {"id": study, "name": name, "config": stored(config), "created_at": BEGIN}
    session.execute(insert(Study), [about])
    luck = np.random.default_rng(0)
    people = [new_id() for _ in range(max(answers // PER_PERSON, PER_ITEM) + 1)]
    common = {"role": "worker", "provider": "load", "profile": {}, "created_at": BEGIN}
    session.execute(insert(Person), [{**common, "id": p, "external_hash": p} for p in people])
    queue = queue_of(study, "rate")
    items, slots, events, given, handouts = [], [], [], [], []
    for i in range(answers // PER_ITEM):
        item = new_id()
        payload = {
            "video": f"video-{i % VIDEOS}",
            "own_video": f"video-{i % VIDEOS}",
            "text": f"Take pallet {i} from the truck to the shelf on the left.",
        }
        items.append(
            {"id": item, "study_id": study, "task": "rate", "subject": f"{i}", "payload": payload,
             "rank": luck.random()}
        )  # fmt: skip
        usual = int(luck.integers(1, 6))
        for j in range(PER_ITEM):
            who = people[(i + j * 7) % len(people)] if len(people) > 40 else people[j]
            number = i * PER_ITEM + j + 1
            seconds = round(float(luck.lognormal(3, 0.5)), 3)
            rating = int(np.clip(usual + luck.integers(-1, 2), 1, 5))
            body = {"rating": rating, "watched_s": round(seconds / 2, 2), "speed": 1.0}
            common = {"item_id": item, "person_id": who, "at": BEGIN + number}
            events.append({**common, "id": number, "uuid": f"{number}", "name": "submit",
                           "body": body})  # fmt: skip
            given.append(
                {**common, "id": number, "task": "rate", "subject": f"{i}", "event_id": number,
                 "study_id": study, "kind": "usual", "body": body, "gist": gist_of("rate", body),
                 "surplus": False, "adopted": True, "seconds": seconds,
                 "odd_below_s": odd_below(payload, body, None), "provenance": None}
            )  # fmt: skip
            slots.append({"item_id": item, "person_id": who, "expires_at": BEGIN, "answered": True,
                          "queue": queue, "rank": items[-1]["rank"]})  # fmt: skip
            handouts.append({**common, "skipped_at": None})
        if luck.random() < OPEN:
            slots.append({"item_id": item, "person_id": None, "expires_at": None, "answered": False,
                          "queue": queue, "rank": items[-1]["rank"]})  # fmt: skip
    tables = (Item, items), (Slot, slots), (Event, events), (Answer, given), (Handout, handouts)
    for table, new in tables:
        session.execute(insert(table), new)
    return study


def seconds_of(session: Session, study: str) -> Mapping[str, float]:
    """Return the seconds that each part of the pages takes."""
    now = session.scalars(select(func.max(Answer.at))).one()
    someone = session.scalars(select(Person.id).order_by(Person.id).limit(1)).one()
    parts: dict[str, Callable[[], object]] = {
        "progress by video": lambda: progress_by_video(session, study, now=now),
        "times": lambda: durations(session, study),
        "history": lambda: histories(session, study, now=now),
        "collected": lambda: collected(session, study),
        "people": lambda: workers(session, study),
        "agreement": lambda: agreement(session, study),
        "at work": lambda: at_work(session, study, now=now),
        "forecast": lambda: forecast(session, study, [], [], now=now),
        "reports": lambda: open_reports(session, study),
        "disagreements": lambda: disagreements(session, study),
        "disputes": lambda: disputes(session, study),
        "somebody's progress": lambda: still_open(session, study, someone, ["rate"]),
    }
    found = {name: best(part, 2, time.process_time)[0] for name, part in parts.items()}
    return {**found, "overview, all parts": sum(found[name] for name in OVERVIEW)}


def export_alone(database: str, form: str) -> None:
    """Print the seconds that an export takes, and the MiB more than there were before it."""
    import pyarrow  # noqa: F401, PLC0415 - so that it doesn't count

    with opened(database) as engine, reading(engine, one_state=True) as session:
        study = session.scalars(select(Study)).one()
        with tempfile.TemporaryFile() as file:
            before, start = most_mib(), time.perf_counter()
            TABLES[form].write(session, study, file)
            seconds = time.perf_counter() - start
    print(json.dumps([seconds, most_mib() - before]))


def measure(database: str, answers: int) -> dict[str, float]:
    """Return milliseconds of the pages' parts, and seconds and MiB of the exports."""
    with opened(database) as engine:
        migrate(engine)
        with transaction(engine) as session:
            study = fill(session, answers)
        with reading(engine) as session:
            found = {f"{name}, ms": 1000 * s for name, s in seconds_of(session, study).items()}
    for form in EXPORTS:
        command = ("-m", "benchmarks.app_dashboard", "--alone", database, form)
        found[f"export {form}, s"], found[f"export {form}, MiB"] = in_own_process(*command)
    return found


def report(name: str, found: Mapping[int, Mapping[str, float]]) -> None:
    """Add the parts of the pages that take longest, and the exports, to the table."""
    sizes = list(found)
    for what in next(iter(found.values())):
        values = [max(one[what], 1e-3) for one in found.values()]
        if what.startswith(("export", "overview", "people", "somebody")):
            row(
                f"{name}, {sizes[0]:,} to {sizes[-1]:,} answers: {what}",
                f"{values[0]:.3g} to {values[-1]:.3g}",
                f"grows with answers to {growth(sizes, values):.2f}",
            )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, prog="python -m benchmarks.app_dashboard")
    parser.add_argument("--answers", type=int, nargs="+", default=[1_000, 10_000, 100_000])
    parser.add_argument("--databases", nargs="+", default=["sqlite", "postgresql"])
    parser.add_argument("--alone", nargs=2, metavar=("DATABASE", "FORM"), help="one export")
    given = parser.parse_args()
    if given.alone:
        export_alone(*given.alone)
        return
    for kind in given.databases:
        with new_databases(kind) as new:
            report(TITLES[kind], {n: measure(new(), n) for n in given.answers})


if __name__ == "__main__":
    main()
