"""Submissions alone, as fast as they go: ``python -m benchmarks.app_submissions``.

Each worker has leased an item to rate; then all send their answers, some at a time. With ``--each``
they go on with the next items, whose leases count, too:

    --databases sqlite --workers 50 --slots 15000 --each 20 --at-once 50

With ``--beside CHECKOUT`` the app of another checkout takes turns with this one, with the same
client. What the servers, PostgreSQL and the workers' own program take of the processor is counted
apart (from /proc, so on Linux only).
"""

from __future__ import annotations

import argparse
import asyncio
import os
import re
import subprocess
import sys
import tempfile
import time
import uuid
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import numpy as np

from annotation_app.core.config import Config, open_instance
from annotation_app.store.database import opened, transaction
from annotation_app.store.schema import migrate
from annotation_app.studies.study_file import RatedPair, StudyConfig, TaskConfig
from annotation_app.study_setup.rendered_study import put_study, rendered_videos
from benchmarks.app import add_workers, cookies
from benchmarks.app_client import Client
from benchmarks.app_servers import PATIENCE_S, processor_s, servers
from benchmarks.app_workers import STUDY
from benchmarks.timing import aim

PAIRS = 20
WHY_NOT_TWICE = "leases no longer take half; what is left is Flask, SQLAlchemy and the disk's turn"


def add_study(config: Config, videos: Path, workers: int, slots: int, each: int) -> list[str]:
    """Fill a new database with pairs to rate; return the workers' ids."""
    pairs = max(PAIRS, 2 * each)
    study = StudyConfig(
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


async def lease(client: Client) -> str:
    """The path for the answer to an item that is now the worker's."""
    if not client.csrf:
        _, session = await client.request("GET", "/api/session", None, PATIENCE_S)
        client.csrf = session["csrf"]
    path = f"/api/studies/{STUDY}/tasks/rate/lease"
    status, page = await client.request("POST", path, {}, PATIENCE_S)
    assert status == 200, page
    return f"/api/items/{page['item']}/answer"


async def submit(client: Client, path: str) -> float:
    """Answer; the seconds that it took."""
    answer = {"uuid": str(uuid.uuid4()), "body": {"rating": 4}}
    start = time.perf_counter()
    status, reply = await client.request("POST", path, answer, PATIENCE_S)
    assert (status, reply["state"]) == (200, "accepted"), reply
    return time.perf_counter() - start


@dataclass(frozen=True)
class Figures:
    """What some submissions took: each in milliseconds, and the processor time of each."""

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
    parser.add_argument("--workers", type=int, default=1000)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--at-once", type=int, nargs="+", default=[2, 8, 32])
    parser.add_argument("--databases", nargs="+", default=["postgresql"])
    parser.add_argument("--slots", type=int, default=0, help="at least (one for each answer)")
    parser.add_argument("--each", type=int, default=1, help="answers of a worker")
    parser.add_argument("--beside", type=Path, metavar="PATH", help="another checkout")
    parser.add_argument("--rounds", type=int, default=2, help="with --beside, of each (2)")
    given = parser.parse_args()
    if given.beside is not None:
        in_turn(given.beside.resolve(), given.rounds)
        return

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
                        show(at_once, asyncio.run(run(ports, signed, at_once, given.each)))


def in_turn(beside: Path, rounds: int) -> None:
    """Run this benchmark with the app of another checkout and with ours, one after the other."""
    ours = Path(__file__).resolve().parents[1]
    arguments = [a for a in sys.argv[1:] if a != "--beside" and Path(a).resolve() != beside]
    command = [sys.executable, "-m", "benchmarks.app_submissions", *arguments]
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "benchmarks").symlink_to(ours / "benchmarks")
        rates: dict[str, list[float]] = {"beside": [], "ours": []}
        spent: dict[str, list[dict[str, float]]] = {"beside": [], "ours": []}
        for _ in range(rounds):
            for name, checkout in (("beside", beside), ("ours", ours)):
                path = f"{folder}{os.pathsep}{checkout}"
                surroundings = {**os.environ, "PYTHONPATH": path}
                done = subprocess.run(
                    command, cwd=folder, env=surroundings, check=True, stdout=subprocess.PIPE
                )
                said = done.stdout.decode()
                print(f"{name}: {said}", end="", flush=True)
                rates[name] += map(float, re.findall(r"(\d+) submissions/s", said))
                each = re.findall(r"(\w+) ([\d.]+) ms", said.partition("each: ")[2])
                spent[name].append({part: float(ms) for part, ms in each})
    before, now = median(rates["beside"]), median(rates["ours"])
    measured = f"{now:.0f}, before {before:.0f}: {now / before:.2f} times"
    what = "submissions a second, in turn with the checkout beside"
    aim(what, measured, "2 times", reached=now >= 2 * before, reason=WHY_NOT_TWICE)
    servers_ms, workers_ms = (
        {name: median(one[part] for one in of) for name, of in spent.items()}
        for part in ("servers", "workers")
    )
    gain = servers_ms["beside"] / servers_ms["ours"]
    after, first = servers_ms["ours"], servers_ms["beside"]
    share = workers_ms["ours"] / (after + workers_ms["ours"])
    measured = f"{after:.1f} ms, before {first:.1f}: {gain:.2f} times less; "
    measured += f"the benchmark's workers {workers_ms['ours']:.1f} ms, {share:.0%} of both"
    what = "the same, processor time of the servers alone, a submission and its lease"
    aim(what, measured, "2 times less", reached=gain >= 2, reason=WHY_NOT_TWICE)


def show(at_once: int, found: Figures) -> None:
    print(
        f"  {at_once:3} at once: {found.per_s:5.0f} submissions/s, p50 {found.p50:.0f} ms, "
        f"p95 {found.p95:.0f} ms; processor time each: "
        + ", ".join(f"{name} {ms:.1f} ms" for name, ms in found.processor.items())
    )


if __name__ == "__main__":
    main()
