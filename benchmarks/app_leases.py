"""A lease, by the number of open slots: ``python -m benchmarks.app_leases``.

New people take an item to rate, at random, from studies of more and more open slots. SQLite's time
is of the processor, PostgreSQL's until the reply.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from statistics import median

import numpy as np
from sqlalchemy import Engine, insert
from sqlalchemy.orm import Session

from annotation_app.core.random_ids import new_id
from annotation_app.items.assignment import Lease, take
from annotation_app.store.database import opened, transaction
from annotation_app.store.models import Item, Person, Slot, Study, queue_of
from annotation_app.store.schema import migrate
from annotation_app.studies.study_file import StudyConfig, TaskConfig, stored
from benchmarks.app_servers import new_databases
from benchmarks.timing import growth, row

ANSWERS = 5
NOW = 1_000_000.0
CLOCKS: dict[str, tuple[str, Callable[[], float]]] = {
    "sqlite": ("SQLite, processor time", time.thread_time),
    "postgresql": ("PostgreSQL, time until the reply", time.perf_counter),
}


def fill(session: Session, slots: int) -> Study:
    """Add a study with items to rate, each with slots for `ANSWERS` people."""
    config = StudyConfig(name="load", title="Load", tasks={"rate": TaskConfig(answers=ANSWERS)})
    study = Study(id=new_id(), name="load", config=stored(config), created_at=NOW)
    session.add(study)
    session.flush()
    luck = np.random.default_rng(0)
    ids = [new_id() for _ in range(slots // ANSWERS)]
    common = {"study_id": study.id, "task": "rate", "payload": {"video": "one", "text": "Go."}}
    items = [
        {**common, "id": one, "subject": f"{i}", "rank": luck.random()} for i, one in enumerate(ids)
    ]
    session.execute(insert(Item), items)
    queue = queue_of(study.id, "rate")
    free = [
        {"item_id": item["id"], "queue": queue, "rank": item["rank"], "lot": luck.random()}
        for item in items
        for _ in range(ANSWERS)
    ]
    session.execute(insert(Slot), free)
    return study


def take_slot(session: Session, study: Study, person: Person) -> None:
    found = take(session, study.id, "rate", person, now=NOW, lease_s=60, in_random_order=True)
    assert isinstance(found, Lease)


def measure(engine: Engine, slots: int, repeats: int, clock: Callable[[], float]) -> float:
    """Return the milliseconds of a lease in the median."""
    with transaction(engine) as session:
        study = fill(session, slots)
        session.flush()
        session.expunge(study)
    seconds = []
    for i in range(repeats):
        with transaction(engine) as session:
            person = Person(
                id=new_id(), role="worker", provider="load", external_hash=f"{i}", profile={},
                created_at=NOW,
            )  # fmt: skip
            session.add(person)
            session.flush()
            start = clock()
            take_slot(session, study, person)
            seconds.append(clock() - start)
    return 1000 * median(seconds)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, prog="python -m benchmarks.app_leases")
    parser.add_argument("--slots", type=int, nargs="+", default=[1_000, 10_000, 100_000])
    parser.add_argument("--repeats", type=int, default=30)
    parser.add_argument("--databases", nargs="+", default=["sqlite", "postgresql"])
    given = parser.parse_args()
    for kind in given.databases:
        title, clock = CLOCKS[kind]
        found = []
        with new_databases(kind) as new:
            for slots in given.slots:
                with opened(new()) as engine:
                    migrate(engine)
                    found.append(measure(engine, slots, given.repeats, clock))
        row(
            f"a lease, {title}, {given.slots[0]:,} to {given.slots[-1]:,} open slots",
            f"{found[0]:.2f} to {found[-1]:.2f} ms",
            f"grows with slots to {growth(given.slots, found):.2f}",
        )


if __name__ == "__main__":
    main()
