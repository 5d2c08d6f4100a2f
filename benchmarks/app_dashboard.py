"""Large studies: ``python -m benchmarks.app_dashboard``.

Studies of more and more answers are filled: each item of a video was rated by several people. The
processor time of leases and of the dashboard's pages and the memory of exports show how they grow.
Each export is made in a process of its own. PostgreSQL's own time doesn't count.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Callable, Mapping
from statistics import median

from sqlalchemy import func, select
from sqlalchemy.orm import Session

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
from annotation_app.items.assignment import Lease, still_open, take
from annotation_app.store.database import opened, reading, transaction
from annotation_app.store.models import Answer, Person, Study
from annotation_app.store.schema import migrate
from benchmarks.timing import best, growth, in_own_process, most_mib, row
from tests.annotation_app.large_study import BEGIN, fill
from tests.annotation_app.load import add_workers
from tests.annotation_app.load_servers import new_databases

OVERVIEW = (
    "progress by video", "times", "history", "collected", "people", "agreement", "at work",
    "forecast", "reports", "disputes",
)  # fmt: skip
"""The parts of the dashboard's first page."""
TITLES = {"sqlite": "SQLite", "postgresql": "PostgreSQL"}
LEASES = 15
EXPORTS = ("csv", "jsonl", "parquet", "reports.csv")


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


def lease_s(session: Session, study: str) -> float:
    """Return the median of the seconds in which new people lease an item, at random."""
    seconds = []
    people = add_workers(session, study, LEASES)
    session.flush()
    for person in people:
        taker = session.get_one(Person, person)
        start = time.thread_time()
        item = take(session, study, "rate", taker, now=BEGIN, lease_s=60, in_random_order=True)
        seconds.append(time.thread_time() - start)
        assert isinstance(item, Lease)
    return median(seconds)


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
            seconds = lease_s(session, study)
        with reading(engine) as session:
            found = {f"{name}, ms": 1000 * s for name, s in seconds_of(session, study).items()}
    found["a lease, ms"] = 1000 * seconds
    for form in EXPORTS:
        command = ("-m", "benchmarks.app_dashboard", "--alone", database, form)
        found[f"export {form}, s"], found[f"export {form}, MiB"] = in_own_process(*command)
    return found


def report(name: str, found: Mapping[int, Mapping[str, float]]) -> None:
    """Add the parts of the pages that take longest, and the exports, to the table."""
    sizes = list(found)
    for what in next(iter(found.values())):
        values = [max(one[what], 1e-3) for one in found.values()]
        if what.startswith(("a lease", "export", "overview", "people", "somebody")):
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
