"""The annotation app under many workers: ``python -m benchmarks.app``.

Real servers, and workers who lose their connection, send twice, try again, and see servers
killed and started again, and the database too. Afterwards every answer that was acknowledged must
be there once, quotas must be exact, and nobody may have had an item twice.
"""

from __future__ import annotations

import argparse
import asyncio
import math
import os
import resource
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from flask.sessions import SecureCookieSessionInterface
from sqlalchemy import func, select
from sqlalchemy.orm import Session

from annotation_app.core.config import Config, open_instance
from annotation_app.core.random_ids import new_id
from annotation_app.people.participants import hashed, keep_consent
from annotation_app.serving.factory import create_app
from annotation_app.store.database import open_database, reading, transaction
from annotation_app.store.models import Answer, Event, Item, Person, Slot, Study
from annotation_app.store.schema import migrate
from annotation_app.studies.study_file import StudyConfig, TaskConfig
from annotation_app.study_setup.rendered_study import put_study
from benchmarks.app_servers import new_databases, processor_s, servers
from benchmarks.app_workers import STUDY, Tally, spread, work_all
from benchmarks.timing import aim

VIDEOS = 6
RATINGS = 1


def add_study(config: Config, videos: Path, workers: int, answers: int) -> list[str]:
    """Fill a new database; return the workers' ids."""
    from annotation_app.study_setup.rendered_study import rendered_videos  # noqa: PLC0415

    engine = open_database(config.database)
    migrate(engine)
    study = StudyConfig(
        name=STUDY,
        title="Load",
        tasks={
            "describe": TaskConfig(answers=answers, practice=False),
            "rate": TaskConfig(answers=RATINGS, practice=False),
        },
    )
    with transaction(engine) as session:
        made = put_study(session, study, rendered_videos(videos))
        people = add_workers(session, made.id, workers)
    engine.dispose()
    return people


def add_workers(session: Session, study: str, count: int) -> list[str]:
    """Add workers who have agreed to a study; return their ids."""
    people = [
        Person(
            id=new_id(),
            role="worker",
            provider="load",
            external_hash=hashed(b"", "load", str(i)),
            profile={},
            created_at=0.0,
        )
        for i in range(count)
    ]
    for person in people:
        keep_consent(person, study, {})
    session.add_all(people)
    return [person.id for person in people]


def cookies(config: Config, people: Sequence[str]) -> list[str]:
    """What the browsers of people who have signed in hold."""
    engine = open_database(config.database)
    app = create_app(config, engine)
    signer = SecureCookieSessionInterface().get_signing_serializer(app)
    assert signer is not None
    signed = [str(signer.dumps({"person": person})) for person in people]
    engine.dispose()
    return signed


def check(config: Config, tally: Tally, *, whole: bool = True) -> Counter[str]:
    """Fail unless all that was acknowledged is there once and quotas are exact.

    Parameters
    ----------
    whole
        Whether people worked until nothing was left; else quotas are only not exceeded.
    """
    engine = open_database(config.database)
    with reading(engine) as session:
        events = Counter(session.scalars(select(Event.uuid)))
        rows = session.execute(select(Event.uuid, Answer).join(Answer, Answer.event_id == Event.id))
        by_event = {row.uuid: row.Answer for row in rows}
        answers = session.scalars(select(Answer)).all()
        slots = session.execute(
            select(Item.id, Item.task, func.count(Slot.id)).join(Slot).group_by(Item.id, Item.task)
        ).all()
        study = session.scalars(select(Study)).one()
    engine.dispose()
    for event, state in tally.acknowledged.items():
        assert events[event] == 1, f"{event} is there {events[event]} times"
        if state != "repeated":
            assert by_event[event].surplus == (state == "surplus")
    quotas = {task: value["answers"] for task, value in study.config["tasks"].items()}
    counted = Counter(a.item_id for a in answers if not a.surplus)
    for item, task, count in slots:
        assert count == quotas[task]
        right = counted[item] == quotas[task] if whole else counted[item] <= quotas[task]
        assert right, f"{task} {item}: {counted[item]} answers"
    pairs = Counter((a.person_id, a.task, a.subject) for a in answers)
    assert max(pairs.values()) == 1
    assert len({a.event_id for a in answers}) == len(answers)
    return Counter(tally.acknowledged.values())


def run_load(
    config: Config,
    videos: Path,
    *,
    workers: int,
    answers: int,
    processes: int,
    think_s: float,
    kills: int = 1,
    database_troubles: Sequence[Callable[[], None]] = (),
    threads: int = 8,
    seconds: float = math.inf,
    warm_up_s: float = 0.0,
) -> Tally:
    """Let workers work until nothing is left or their time is over; return what they saw.

    Parameters
    ----------
    answers
        How many people describe each video.
    think_s
        How long a worker waits between requests, on average.
    kills
        How often a server is killed and started again, one after the other in turn.
    database_troubles
        What is done to the database, one after the other, while people work.
    seconds
        After which nobody sends anything more.
    warm_up_s
        How long requests don't count at first.
    """
    people = add_study(config, videos, workers, answers)
    signed = cookies(config, people)
    tally = Tally()
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with servers(config, processes, threads) as running:
        start = time.monotonic()
        processor = processor_s()
        tally.counts_from = start + warm_up_s
        killed = [running[i % processes].kill_and_restart for i in range(kills)]
        total = len(list(videos.iterdir())) * answers * (1 + 2 * RATINGS)
        troubles = spread(killed, total)
        for count, makers in spread(database_troubles, total).items():
            troubles.setdefault(count, []).extend(makers)
        asyncio.run(work_all(running, signed, tally, think_s, troubles, seconds=seconds))
        tally.wall_s = time.monotonic() - tally.counts_from
        tally.processor = {name: s - processor[name] for name, s in processor_s().items()}
    if kills:  # only those who are over tell what killed servers took
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        own = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        tally.processor["servers"] = own
    return tally


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, prog="python -m benchmarks.app")
    parser.add_argument("--workers", type=int, default=200)
    parser.add_argument("--processes", type=int, nargs="+", default=[1, 4])
    parser.add_argument("--think", type=float, default=2.0, help="mean seconds between requests")
    parser.add_argument("--no-kill", action="store_true", help="leave the servers alone")
    parser.add_argument("--databases", nargs="+", default=["sqlite", "postgresql"])
    parser.add_argument("--seconds", type=float, default=math.inf, help="nobody sends after that")
    parser.add_argument("--warm-up", type=float, default=0.0, help="seconds that don't count (0)")
    given = parser.parse_args()

    from tests.annotation_app.rendered import render  # noqa: PLC0415 - needs pytest

    print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}, {given.workers} workers")
    with tempfile.TemporaryDirectory() as folder:
        videos = render(Path(folder) / "videos", tuple(f"video{i}" for i in range(VIDEOS)))
        for kind in given.databases:
            with new_databases(kind) as new:
                for processes in given.processes:
                    config = open_instance(Path(folder) / f"{kind}-{processes}", new())
                    tally = run_load(
                        config,
                        videos,
                        workers=given.workers,
                        answers=max(1, given.workers // 4),
                        processes=processes,
                        think_s=given.think,
                        kills=0 if given.no_kill else 1,
                        seconds=given.seconds,
                        warm_up_s=given.warm_up,
                    )
                    states = check(config, tally, whole=given.seconds == math.inf)
                    _report(f"{kind}, {processes} processes", tally, states, given.workers)


def _report(title: str, tally: Tally, states: Counter[str], workers: int) -> None:
    every = [s for values in tally.seconds.values() for s in values]
    rate = len(every) / tally.wall_s
    spent = tally.processor.items()
    each = ", ".join(f"{name} {1000 * s / tally.requests:.1f} ms" for name, s in spent)
    print(
        f"\n{title}: {rate:.0f} requests/s for {tally.wall_s:.0f} s, load {os.getloadavg()[0]:.1f}"
    )
    print(f"  processor time of a request: {each}")
    print(f"  {dict(states)}; {dict(tally.broken)}")
    for name, values in [*sorted(tally.seconds.items()), ("all", every)]:
        p50, p95, p99 = 1000 * np.percentile(values, [50, 95, 99])
        print(f"  {name:8} {len(values):6} p50 {p50:6.0f} ms, p95 {p95:6.0f} ms, p99 {p99:6.0f} ms")
    measured = f"{p95:.0f} ms at {rate:.0f} requests/s; processor time of each: {each}"
    aim(f"p95, {workers} workers, {title}", measured, "150 ms", reached=bool(p95 <= 150))


if __name__ == "__main__":
    main()
