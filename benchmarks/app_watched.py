"""Workers while somebody watches the dashboard: ``python -m benchmarks.app_watched``.

Workers rate items, with a pause after each. First nobody looks at the dashboard. Then the overview
of a study with 100 000 answers is asked for again and again, a second after the last reply.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import random
import tempfile
import time
import urllib.request
import uuid
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from annotation_app.core.config import open_instance
from annotation_app.core.random_ids import new_id
from annotation_app.store.database import opened, transaction
from annotation_app.store.models import Person
from benchmarks.app import cookies
from benchmarks.app_client import Client
from benchmarks.app_dashboard import fill
from benchmarks.app_servers import PATIENCE_S, servers
from benchmarks.app_submissions import add_study, lease
from benchmarks.timing import aim

PAUSE_S = 1.0
LARGE = "large"
"""The study that is looked at."""


async def rate(client: Client, until: float, think_s: float) -> list[float]:
    """Rate items until a time; the seconds that each request took."""
    seconds: list[float] = []
    while time.monotonic() < until:
        await asyncio.sleep(random.expovariate(1 / think_s))
        start = time.perf_counter()
        path = await lease(client)
        seconds.append(time.perf_counter() - start)
        answer = {"uuid": str(uuid.uuid4()), "body": {"rating": 4}}
        start = time.perf_counter()
        status, reply = await client.request("POST", path, answer, PATIENCE_S)
        seconds.append(time.perf_counter() - start)
        assert status == 200, reply
    return seconds


def look(port: int, cookie: str) -> float:
    """Open the overview; the seconds that it took."""
    page = f"http://127.0.0.1:{port}/dashboard/{LARGE}"
    request = urllib.request.Request(page, headers={"Cookie": f"session={cookie}"})
    start = time.perf_counter()
    with urllib.request.urlopen(request, timeout=PATIENCE_S) as reply:
        assert reply.status == 200
        reply.read()
    return time.perf_counter() - start


async def watch(port: int, cookie: str, until: float) -> list[float]:
    """Open the overview again and again until a time; the seconds that each took."""
    seconds: list[float] = []
    while time.monotonic() < until:
        seconds.append(await asyncio.to_thread(look, port, cookie))
        await asyncio.sleep(PAUSE_S)
    return seconds


async def measure(
    ports: Sequence[int], signed: Sequence[str], watcher: str, seconds: float, think_s: float
) -> tuple[list[float], list[float]]:
    """How long requests took, and pages of the dashboard if somebody watches."""
    clients = [Client(ports[i % len(ports)], cookie) for i, cookie in enumerate(signed)]
    until = time.monotonic() + seconds
    watched = watch(ports[0], watcher, until) if watcher else asyncio.sleep(0, [])
    pages, *found = await asyncio.gather(watched, *(rate(c, until, think_s) for c in clients))
    for client in clients:
        client.close()
    return [s for of_worker in found for s in of_worker], pages


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, prog="python -m benchmarks.app_watched")
    parser.add_argument("--answers", type=int, default=100_000)
    parser.add_argument("--workers", type=int, default=20)
    parser.add_argument("--think", type=float, default=1.0, help="mean seconds (1)")
    parser.add_argument("--seconds", type=float, default=20.0, help="of each part (20)")
    parser.add_argument("--processes", type=int, default=1)
    given = parser.parse_args()

    from tests.annotation_app.rendered import render  # noqa: PLC0415 - needs pytest

    print(f"SQLite, {given.processes} processes, load {os.getloadavg()[0]:.1f}")
    with tempfile.TemporaryDirectory() as name:
        config = open_instance(Path(name) / "instance", None)
        videos = render(Path(name) / "videos", ("one", "two"))
        slots = int(10 * given.workers * given.seconds / given.think)
        people = add_study(config, videos, given.workers, slots, slots // given.workers)
        with opened(config.database) as engine, transaction(engine) as session:
            fill(session, given.answers, LARGE)
            watching = {"provider": "load", "external_hash": "watcher", "profile": {}}
            people.append(new_id())
            session.add(Person(id=people[-1], role="adjudicator", created_at=0.0, **watching))
        *signed, watcher = cookies(config, people)
        p95 = {}
        with servers(config, given.processes, threads=8) as running:
            ports = [server.port for server in running]
            for what, by in (("alone", ""), ("watched", watcher)):
                found, pages = asyncio.run(measure(ports, signed, by, given.seconds, given.think))
                p50, p95[what] = 1000 * np.percentile(found, [50, 95])
                took = f"; {len(pages)} pages, median {np.median(pages):.2f} s" if pages else ""
                least = f"{len(found)} requests, p50 {p50:.0f} ms, p95 {p95[what]:.0f} ms"
                print(f"  {what}: {least}{took}")
    aim(
        f"p95 of {given.workers} workers while the dashboard is asked, {given.answers:,} answers, "
        f"server processes: {given.processes}",
        f"{p95['watched']:.0f} ms, otherwise {p95['alone']:.0f}; a page {np.median(pages):.2f} s",
        "unchanged: at most a quarter more",
        reached=bool(p95["watched"] <= 1.25 * p95["alone"]),
        reason="workers wait while Python makes the page in the same process",
    )


if __name__ == "__main__":
    main()
