"""Workers of the annotation app who lose their connection, send twice and try again."""

from __future__ import annotations

import asyncio
import contextlib
import random
import time
import uuid
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from benchmarks.app_client import LOST, Client
from benchmarks.app_servers import PATIENCE_S, Server

STUDY = "load"
"""The study that they work at."""
UNAVAILABLE = 503
"""What servers answer while the database is gone."""


@dataclass
class Tally:
    """What the workers saw, and what it took.

    Parameters
    ----------
    seconds
        That requests took, by their kind.
    acknowledged
        What became of answers, by their uuid.
    broken
        What went wrong.
    wall_s
        From the first request to the last reply.
    processor
        Seconds meanwhile of the servers (with their start, if one was killed), of PostgreSQL, and
        of the workers' own program.
    requests
        All that were answered, those of the warm-up, too.
    counts_from
        When the warm-up is over, by :func:`time.monotonic`: requests that end before don't count.
    """

    seconds: dict[str, list[float]] = field(default_factory=dict)
    acknowledged: dict[str, str] = field(default_factory=dict)
    broken: Counter[str] = field(default_factory=Counter)
    wall_s: float = 0.0
    processor: dict[str, float] = field(default_factory=dict)
    requests: int = 0
    counts_from: float = 0.0

    def add(self, name: str, seconds: float) -> None:
        self.requests += 1
        if time.monotonic() >= self.counts_from:
            self.seconds.setdefault(name, []).append(seconds)


class TimeIsUpError(Exception):
    """Nobody sends anything more."""


class Worker:
    """Somebody who works until there is nothing left, on a connection that can't be trusted."""

    def __init__(
        self, port: int, cookie: str, tally: Tally, think_s: float, seed: int, *, until: float
    ) -> None:
        self.client = Client(port, cookie)
        self.tally = tally
        self.think_s = think_s
        self.comes_back = seed % 10 == 0
        self.luck = random.Random(seed)
        self.until = until

    async def work(self) -> None:
        with contextlib.suppress(TimeIsUpError), contextlib.closing(self.client):
            await self.think()
            self.client.csrf = (await self.send("session", "GET", "/api/session"))[1]["csrf"]
            for task in ("describe", "rate"):
                while await self.do(task):
                    pass

    async def do(self, task: str) -> bool:
        """Do an item; whether there may be another one."""
        await self.think()
        path = f"/api/studies/{STUDY}/tasks/{task}/lease"
        status, page = await self.send("lease", "POST", path, {})
        if status == 409:
            # Where others have all that is left, most people don't wait for it.
            if page["reason"] != "all taken" or not self.comes_back:
                return False
            await asyncio.sleep(2 + self.luck.random())
            return True
        item = page["item"]
        text = f"Go to number {self.luck.randrange(10**9)}"
        body = {"text": text, "played_to_end": True} if task == "describe" else {"rating": 4}
        await self.think()
        draft = {"revision": 1, "body": body}
        await self.send("draft", "PUT", f"/api/items/{item}/draft", draft)
        await self.think()
        await self.answer(item, body)
        return True

    async def answer(self, item: str, body: dict[str, Any]) -> None:
        path, event = f"/api/items/{item}/answer", str(uuid.uuid4())
        value = {"uuid": event, "body": body}
        luck = self.luck.random()
        if luck < 0.1:  # the connection breaks; nobody knows whether the answer has come
            self.tally.broken["cut off"] += 1
            with contextlib.suppress(*LOST):
                await self.client.request("POST", path, value, self.luck.uniform(0.001, 0.05))
        if luck > 0.9:  # a double click
            self.tally.broken["doubled"] += 1
            replies = await asyncio.gather(
                *(self.send("answer", "POST", path, value) for _ in range(2))
            )
        else:
            replies = [await self.send("answer", "POST", path, value)]
        states = {reply["state"] for _, reply in replies}
        assert len(states) == 1, states
        self.tally.acknowledged[event] = states.pop()

    async def send(self, name: str, method: str, path: str, value: Any = None) -> tuple[int, Any]:
        end = time.monotonic() + 3 * PATIENCE_S
        while time.monotonic() < end:
            start = time.perf_counter()
            try:
                status, reply = await self.client.request(method, path, value, PATIENCE_S)
            except LOST:
                self.tally.broken["tried again"] += 1
                await asyncio.sleep(self.luck.uniform(0.2, 1))
                continue
            if status == UNAVAILABLE:
                self.tally.broken["put off"] += 1
                await asyncio.sleep(self.luck.uniform(0.5, 2))
                continue
            assert status in (200, 409), reply
            self.tally.add(name, time.perf_counter() - start)
            return status, reply
        raise TimeoutError(path)

    async def think(self) -> None:
        wait_s = self.luck.expovariate(1 / self.think_s)
        await asyncio.sleep(min(wait_s, self.until - time.monotonic()))
        if time.monotonic() > self.until:
            raise TimeIsUpError


async def work_all(
    running: Sequence[Server],
    signed: Sequence[str],
    tally: Tally,
    think_s: float,
    troubles: Mapping[int, Sequence[Callable[[], None]]],
    *,
    seconds: float,
) -> None:
    until = time.monotonic() + seconds
    workers = [
        Worker(running[i % len(running)].port, cookie, tally, think_s, i, until=until)
        for i, cookie in enumerate(signed)
    ]
    tasks = [asyncio.create_task(worker.work()) for worker in workers]
    for count, makers in sorted(troubles.items()):
        while len(tally.acknowledged) < count and not all(task.done() for task in tasks):
            await asyncio.sleep(0.01)
        for make in makers:
            await asyncio.to_thread(make)
    await asyncio.gather(*tasks)


def spread(makers: Sequence[Callable[[], None]], total: int) -> dict[int, list[Callable[[], None]]]:
    """After how many answers each trouble comes, so that all come while people work."""
    found: dict[int, list[Callable[[], None]]] = {}
    for i, make in enumerate(makers, start=1):
        found.setdefault(total * i // (len(makers) + 1), []).append(make)
    return found
