"""A lease, by how many slots are open: ``python -m benchmarks.app_leases``.

People who are new take an item to rate, at random, from studies of more and more open slots. In
turn with it runs what is simpler: to sort all free slots in a random order, without an index. The
processor time of this process is counted, so SQLite's with it, and not PostgreSQL's own, for which
the time until the reply counts.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable, Sequence
from statistics import median

import numpy as np
from sqlalchemy import Engine, func, insert, select, update
from sqlalchemy.orm import Session

from annotation_app.core.random_ids import new_id
from annotation_app.items import assignment
from annotation_app.items.assignment import ITEM, SLOT, Lease, take
from annotation_app.store.database import opened, transaction
from annotation_app.store.models import Item, Person, Slot, Study, queue_of
from annotation_app.store.schema import migrate
from annotation_app.studies.study_file import StudyConfig, TaskConfig, stored
from benchmarks.app_servers import new_databases
from benchmarks.timing import aim, heading

ANSWERS = 5
NOW = 1_000_000.0
CLOCKS: dict[str, tuple[str, Callable[[], float]]] = {
    "sqlite": ("SQLite, processor time", time.thread_time),
    "postgresql": ("PostgreSQL, time until the reply", time.perf_counter),
}


def fill(session: Session, slots: int) -> Study:
    """A study with items to rate, each with slots for `ANSWERS` people."""
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


def take_by_sorting(session: Session, study: Study, person: Person) -> None:
    """Sort all free slots at random, and take the first."""
    about = {"of_study": study.id, "of_task": "rate", "who": person.id, "at_present": NOW}
    about |= {"until": NOW + 60, "latest": NOW + 60}
    session.execute(_SORTING, about)


def take_ours(session: Session, study: Study, person: Person) -> None:
    """Take a slot as the app does."""
    found = take(session, study.id, "rate", person, now=NOW, lease_s=60, in_random_order=True)
    assert isinstance(found, Lease)


_FREE = (
    select(SLOT.c.id)
    .join(ITEM)
    .where(*assignment._OF_TASK, *assignment._can_be_taken(), *assignment._is_new())
    .order_by(func.random())
    .limit(1)
    .with_for_update(of=SLOT, skip_locked=True)
)
_SORTING = (
    update(SLOT)
    .where(SLOT.c.id == _FREE.scalar_subquery())
    .values(person_id=assignment._WHO, expires_at=assignment._UNTIL)
)


def measure(engine: Engine, slots: int, repeats: int, clock: Callable[[], float]) -> list[float]:
    """Milliseconds of a lease, ours and by sorting."""
    with transaction(engine) as session:
        study = fill(session, slots)
        session.flush()
        session.expunge(study)
    seconds: tuple[list[float], list[float]] = ([], [])
    for i in range(repeats):
        for way, action in zip(seconds, (take_ours, take_by_sorting), strict=True):
            with transaction(engine) as session:
                person = Person(
                    id=new_id(), role="worker", provider="load", external_hash=f"{i} {action}",
                    profile={}, created_at=NOW,
                )  # fmt: skip
                session.add(person)
                session.flush()
                start = clock()
                action(session, study, person)
                way.append(clock() - start)
    return [1000 * median(way) for way in seconds]


def show(name: str, sizes: Sequence[int], found: Sequence[Sequence[float]]) -> None:
    heading(f"{name}, load {os.getloadavg()[0]:.1f}")
    print(f"  {'open slots':>10} {'ours':>10} {'by sorting':>12} {'ours / sorting':>16}")
    for slots, (ours, sorting) in zip(sizes, found, strict=True):
        print(f"  {slots:>10,} {ours:>7.2f} ms {sorting:>9.2f} ms {ours / sorting:>16.3f}")
    if len(sizes) > 1:
        slopes = np.polyfit(np.log(sizes), np.log(np.array(found)), 1)[0]
        print("  time grows with slots to the power of {:.2f}; {:.2f}".format(*slopes))
        what = f"a lease, {name}, {sizes[0]:,} to {sizes[-1]:,} open slots"
        measured = f"{found[0][0]:.2f} to {found[-1][0]:.2f} ms, exponent {slopes[0]:.2f}"
        measured += f"; sorting {found[-1][1]:.0f} ms, {slopes[1]:.2f}"
        reached = found[-1][0] <= 2 and slopes[0] < 0.25
        aim(what, measured, "2 ms at 100,000, flat", reached=reached)


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
        show(title, given.slots, found)


if __name__ == "__main__":
    main()
