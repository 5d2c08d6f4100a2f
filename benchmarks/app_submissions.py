"""Submissions alone, as fast as they go: ``python -m benchmarks.app_submissions``.

Each worker has leased an item to rate; then all send their answers, some at a time. With ``--each``
they continue with the next items, whose leases count, too:

    --databases sqlite --workers 50 --slots 15000 --each 20 --at-once 50

What the servers, PostgreSQL and the workers' own program take of the processor is counted apart
(from /proc, so on Linux only).
"""

from __future__ import annotations

import argparse
import asyncio
import os
import tempfile
import time
import uuid
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from flask.sessions import SecureCookieSessionInterface
from sqlalchemy.orm import Session

from annotation_app.core.config import Config, open_instance
from annotation_app.core.random_ids import new_id
from annotation_app.people.participants import hashed, keep_consent
from annotation_app.serving.factory import create_app
from annotation_app.store.database import open_database, opened, transaction
from annotation_app.store.models import Person
from annotation_app.store.schema import migrate
from annotation_app.studies.study_file import RatedPair, StudyConfig, TaskConfig
from annotation_app.study_setup.rendered_study import put_study, rendered_videos
from benchmarks.app_client import Client
from benchmarks.app_servers import PATIENCE_S, processor_s, servers
from benchmarks.timing import row

PAIRS = 20
STUDY = "load"
"""The study that workers work at."""


def add_study(config: Config, videos: Path, workers: int, slots: int, each: int) -> list[str]:
    """Fill a new database with pairs to rate; return the workers' ids."""
    pairs = max(PAIRS, 2 * each)
    study = StudyConfig(
        watching="flagged",
        name=STUDY,
        title="Load",
        tasks={"rate": TaskConfig(answers=-(-slots // pairs), practice=False)},
        pairs=tuple(RatedPair(f"Go to number {i}.", "one", "two") for i in range(pairs)),
    )
    with opened(config.database) as engine:
        migrate(engine)
        with transaction(engine) as session:
            made = put_study(session, study, rendered_videos(videos))
            people = add_workers(session, made.id, workers)
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
    """Return the cookies of people who have signed in."""
    engine = open_database(config.database)
    app = create_app(config, engine)
    signer = SecureCookieSessionInterface().get_signing_serializer(app)
    assert signer is not None
    signed = [str(signer.dumps({"person": person})) for person in people]
    engine.dispose()
    return signed


async def lease(client: Client) -> str:
    """Lease an item for a worker; return the path for its answer."""
    if not client.csrf:
        _, session = await client.request("GET", "/api/session", None, PATIENCE_S)
        client.csrf = session["csrf"]
    path = f"/api/studies/{STUDY}/tasks/rate/lease"
    status, page = await client.request("POST", path, {}, PATIENCE_S)
    assert status == 200, page
    return f"/api/items/{page['item']}/answer"


async def submit(client: Client, path: str) -> float:
    """Submit an answer; return the seconds that it took."""
    answer = {"uuid": str(uuid.uuid4()), "body": {"rating": 4}}
    start = time.perf_counter()
    status, reply = await client.request("POST", path, answer, PATIENCE_S)
    assert (status, reply["state"]) == (200, "accepted"), reply
    return time.perf_counter() - start


@dataclass(frozen=True)
class Figures:
    """Measurements of submissions: milliseconds of each, and the processor time of each."""

    per_s: float
    p50: float
    p95: float
    longest: float
    processor: dict[str, float]


async def run(ports: Sequence[int], signed: Sequence[str], at_once: int, each: int) -> Figures:
    clients = [Client(ports[i % len(ports)], cookie) for i, cookie in enumerate(signed)]
    gate = asyncio.Semaphore(at_once)

    async def leased(client: Client) -> str:
        async with gate:
            return await lease(client)

    async def submitted(client: Client, path: str) -> list[float]:
        async with gate:
            seconds = [await submit(client, path)]
        for _ in range(each - 1):
            path = await leased(client)
            async with gate:
                seconds.append(await submit(client, path))
        return seconds

    paths = await asyncio.gather(*map(leased, clients))
    before, start = processor_s(), time.perf_counter()
    found = await asyncio.gather(*map(submitted, clients, paths))
    seconds = [s for of_worker in found for s in of_worker]
    wall_s = time.perf_counter() - start
    processor = {n: 1000 * (s - before[n]) / len(seconds) for n, s in processor_s().items()}
    for client in clients:
        client.close()
    p50, p95, longest = 1000 * np.percentile(seconds, [50, 95, 100])
    return Figures(len(seconds) / wall_s, p50, p95, longest, processor)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, prog="python -m benchmarks.app_submissions"
    )
    parser.add_argument("--workers", type=int, default=600)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--at-once", type=int, nargs="+", default=[8])
    parser.add_argument("--databases", nargs="+", default=["postgresql"])
    parser.add_argument("--slots", type=int, default=0, help="at least (one for each answer)")
    parser.add_argument("--each", type=int, default=1, help="answers of a worker")
    given = parser.parse_args()

    from tests.annotation_app.conftest import new_database  # noqa: PLC0415 - needs pytest
    from tests.annotation_app.postgres import cluster  # noqa: PLC0415
    from tests.annotation_app.rendered import render  # noqa: PLC0415

    slots = max(given.slots, given.workers * given.each)
    with tempfile.TemporaryDirectory() as folder:
        videos = render(Path(folder) / "videos", ("one", "two"))
        for database in given.databases:
            load = os.getloadavg()[0]
            print(
                f"{database}, {given.processes} processes, {os.cpu_count()} cores, load {load:.1f}"
            )
            with cluster(durable=True) if database == "postgresql" else nullcontext() as url:
                for at_once in given.at_once:
                    instance = Path(folder) / f"{database}-{at_once}"
                    config = open_instance(instance, new_database(url) if url else None)
                    people = add_study(config, videos, given.workers, slots, given.each)
                    signed = cookies(config, people)
                    with servers(config, given.processes, threads=8) as running:
                        ports = [server.port for server in running]
                        found = asyncio.run(run(ports, signed, at_once, given.each))
                    each = ", ".join(f"{n} {ms:.1f} ms" for n, ms in found.processor.items())
                    row(
                        f"submissions, {database}, {at_once} at once",
                        f"{found.per_s:.0f}/s, p50 {found.p50:.0f} ms, p95 {found.p95:.0f} ms",
                        f"processor time of each: {each}",
                    )


if __name__ == "__main__":
    main()
