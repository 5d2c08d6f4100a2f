"""Workers of the annotation app who lose their connection, send twice and try again.

Servers are killed and started again meanwhile, and the database too. Afterwards every answer that
was acknowledged must be there once, quotas must be exact, and nobody may have had an item twice.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import random
import resource
import time
import uuid
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from flask.sessions import SecureCookieSessionInterface
from sqlalchemy import func, select
from sqlalchemy.orm import Session

from annotation_app.core.config import Config
from annotation_app.core.random_ids import new_id
from annotation_app.people.participants import hashed, keep_consent
from annotation_app.serving.factory import create_app
from annotation_app.store.database import open_database, reading, transaction
from annotation_app.store.models import Answer, Event, Item, Person, Slot, Study
from annotation_app.store.schema import migrate
from annotation_app.studies.study_file import StudyConfig, TaskConfig
from annotation_app.study_setup.rendered_study import put_study, rendered_videos
from tests.annotation_app.load_client import LOST, Client
from tests.annotation_app.load_servers import PATIENCE_S, Server, processor_s, servers

STUDY = "load"
RATINGS = 1
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
    """

    seconds: dict[str, list[float]] = field(default_factory=dict)
    acknowledged: dict[str, str] = field(default_factory=dict)
    broken: Counter[str] = field(default_factory=Counter)
    wall_s: float = 0.0
    processor: dict[str, float] = field(default_factory=dict)


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
            self.tally.seconds.setdefault(name, []).append(time.perf_counter() - start)
            return status, reply
        raise TimeoutError(path)

    async def think(self) -> None:
        wait_s = self.luck.expovariate(1 / self.think_s) if self.think_s else 0.0
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


def add_study(config: Config, videos: Path, workers: int, answers: int) -> list[str]:
    """Fill a new database; return the workers' ids."""
    engine = open_database(config.database)
    migrate(engine)
    study = StudyConfig(
        name=STUDY,
        title="Load",
        watching="flagged",
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
    common: dict[str, Any] = {"role": "worker", "provider": "load", "profile": {}}
    hashes = [hashed(b"", "load", str(i)) for i in range(count)]
    people = [Person(id=new_id(), external_hash=h, created_at=0.0, **common) for h in hashes]
    for person in people:
        keep_consent(person, study, {})
    session.add_all(people)
    return [person.id for person in people]


def cookies(config: Config, people: Sequence[str]) -> list[str]:
    """Return the cookies of people who have signed in."""
    engine = open_database(config.database)
    signer = SecureCookieSessionInterface().get_signing_serializer(create_app(config, engine))
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
    """
    people = add_study(config, videos, workers, answers)
    signed = cookies(config, people)
    tally = Tally()
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with servers(config, processes, threads) as running:
        start = time.monotonic()
        processor = processor_s()
        killed = [running[i % processes].kill_and_restart for i in range(kills)]
        total = len(list(videos.iterdir())) * answers * (1 + 2 * RATINGS)
        troubles = spread(killed, total)
        for count, makers in spread(database_troubles, total).items():
            troubles.setdefault(count, []).extend(makers)
        asyncio.run(work_all(running, signed, tally, think_s, troubles, seconds=seconds))
        tally.wall_s = time.monotonic() - start
        tally.processor = {name: s - processor[name] for name, s in processor_s().items()}
    if kills:  # only those who are over tell what killed servers took
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        own = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        tally.processor["servers"] = own
    return tally
