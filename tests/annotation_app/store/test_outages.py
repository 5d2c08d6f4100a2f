"""The database is gone, or its disk is full: nothing is lost, and nobody is flooded with errors."""

from __future__ import annotations

import contextlib
import logging
import resource
import shutil
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pytest
from flask import Flask
from limits.storage import MemoryStorage
from limits.strategies import MovingWindowRateLimiter
from sqlalchemy import create_engine, event, select, text
from sqlalchemy.exc import DBAPIError, IntegrityError, OperationalError
from sqlalchemy.exc import TimeoutError as NoConnectionLeft

from annotation_app.core.config import DATABASE_FILE, Config, open_instance
from annotation_app.serving.factory import create_app
from annotation_app.store import outages
from annotation_app.store.database import opened, reading, transaction
from annotation_app.store.models import Event
from annotation_app.store.outages import Outage, Outages, outage_of
from tests.annotation_app.browser import Browser, described, engine_of, installation_of
from tests.annotation_app.conftest import STUDY, new_database, set_up
from tests.annotation_app.postgres import Cluster, running_cluster
from tests.annotation_app.real_server import Server, new_uuid, running

WORKERS = 6
WAIT_S = 0.25
"""Fewer than 240 requests a minute, which are allowed."""
MOST_LINES = 6


@dataclass
class Traffic:
    """What people who send answers all the time got."""

    acknowledged: list[str] = field(default_factory=list)
    statuses: Counter[int] = field(default_factory=Counter)
    wrong: list[Any] = field(default_factory=list)
    is_over: threading.Event = field(default_factory=threading.Event)

    def wait_for(self, status: int, more: int = 10) -> None:
        enough, end = self.statuses[status] + more, time.monotonic() + 60
        while self.statuses[status] < enough:
            assert time.monotonic() < end, (status, self.statuses, self.wrong)
            assert not self.wrong
            time.sleep(0.05)


@contextmanager
def traffic(server: Server, people: Sequence[Browser]) -> Iterator[Traffic]:
    """Each of the people sends answers and drafts, again if it wasn't their fault."""
    seen = Traffic()

    def work(person: Browser) -> None:
        client = server.client(person)
        item, sent, revision = person.take("describe")["item"], new_uuid(), 0
        while not seen.is_over.is_set():
            time.sleep(WAIT_S)
            try:
                if revision % 4 == 3:
                    draft = {"revision": revision, "body": {"text": "Go"}}
                    status, reply, headers = client.send("PUT", f"/api/items/{item}/draft", draft)
                else:
                    status, reply, headers = client.answer(item, described(), sent)
            except OSError as error:
                seen.wrong.append(error)
                continue
            seen.statuses[status] += 1
            if status == 200:
                if revision % 4 != 3:
                    seen.acknowledged.append(sent)
                    sent = new_uuid()
                revision += 1
            elif not (status == 503 and headers["retry-after"] == "10" and TOLD in reply["error"]):
                seen.wrong.append((status, reply, headers))

    with ThreadPoolExecutor(len(people)) as pool:
        working = [pool.submit(work, person) for person in people]
        try:
            yield seen
        finally:
            seen.is_over.set()
        for done in working:
            done.result()


TOLD = "answers that you have sent wait in your browser, and are sent by themselves"


def check(config: Config, server: Server, seen: Traffic, *kinds: str) -> None:
    """Nothing that was acknowledged is lost or doubled, and the log is short."""
    assert seen.wrong == []
    assert set(seen.statuses) == {200, 503}
    with opened(config.database) as engine, reading(engine) as session:
        events = Counter(session.scalars(select(Event.uuid)))
    assert set(seen.acknowledged) <= set(events)
    assert set(events.values()) == {1}
    assert len(events) <= len(seen.acknowledged) + WORKERS  # the last of each may be unheard of
    logged = server.logged()
    assert len(logged) <= MOST_LINES, logged
    for line in logged:
        assert line.startswith(
            ("ERROR annotation_app.store.outages: ", "WARNING annotation_app.store.outages")
        )
        assert any(kind in line for kind in kinds), line
    assert any(": over after " in line for line in logged)


@pytest.fixture(scope="module")
def own_cluster() -> Iterator[Cluster]:
    """A cluster that may be stopped."""
    with running_cluster(durable=True) as made:
        yield made


@pytest.mark.slow
@pytest.mark.parametrize("how", ["fast", "immediate"])
def test_postgresql_is_stopped_and_started(
    own_cluster: Cluster, how: str, videos: Path, tmp_path: Path
) -> None:
    instance = open_instance(tmp_path / "instance")
    config = replace(instance, database=new_database(own_cluster.url))
    set_up(config.database, STUDY, videos)
    with opened(config.database) as engine:
        app = create_app(config, engine)
        people = [Browser(app) for _ in range(WORKERS)]
        with running(config, tmp_path) as server:
            client = server.client(people[0])
            with traffic(server, people) as seen:
                seen.wait_for(200)
                own_cluster.stop(how)
                seen.wait_for(503, 3 * WORKERS)
                status, page, headers = client.send("GET", "/s/tests", None)
                assert status == 503
                assert TOLD in page
                assert headers["retry-after"] == "10"
                own_cluster.start()
                before = seen.statuses[503]
                seen.wait_for(200, 5 * WORKERS)
                assert seen.statuses[503] - before <= 2 * WORKERS
                time.sleep(outages.QUIET_S)
                seen.wait_for(200)
            assert server.end() == 0
    check(config, server, seen, "the database can't be reached")


@pytest.mark.slow
def test_the_sqlite_file_is_moved_away_and_back(app: Flask, config: Config, tmp_path: Path) -> None:
    """Meanwhile nothing is written to it, and no empty one is made."""
    file = Path(config.database)
    people = [Browser(app) for _ in range(WORKERS)]
    engine_of(app).dispose()
    with running(config, tmp_path) as server:
        with traffic(server, people) as seen:
            seen.wait_for(200)
            moved = file.rename(file.with_name("moved"))
            seen.wait_for(503, 3 * WORKERS)
            content = moved.read_bytes()
            seen.wait_for(503, 3 * WORKERS)
            assert moved.read_bytes() == content
            assert not file.exists()
            moved.rename(file)
            seen.wait_for(200, 5 * WORKERS)
            time.sleep(outages.QUIET_S)
            seen.wait_for(200)
        assert server.end() == 0
    check(config, server, seen, "the database can't be reached")


@contextmanager
def small_disk(folder: Path) -> Iterator[tuple[Path, Callable[[Server, bool], None]]]:
    """A disk of 6 MB, and what fills it or frees it again."""
    folder.mkdir()
    made = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=6m", "tmpfs", str(folder)],
        check=False,
        capture_output=True,
        text=True,
    )
    if made.returncode:
        pytest.skip(f"a small disk can't be mounted: {made.stderr.strip()}")
    filler = folder / "filler"

    def fill(_server: Server, full: bool) -> None:
        if full:
            with filler.open("wb", buffering=0) as file, contextlib.suppress(OSError):
                while file.write(bytes(4096)):
                    pass
        else:
            filler.unlink()

    try:
        yield folder, fill
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


@contextmanager
def limited_files(folder: Path) -> Iterator[tuple[Path, Callable[[Server, bool], None]]]:
    """A disk on which the server's files can't grow."""
    folder.mkdir()

    def fill(server: Server, full: bool) -> None:
        wal = folder / f"{DATABASE_FILE}-wal"
        size = wal.stat().st_size if full else resource.RLIM_INFINITY
        limits = size, resource.RLIM_INFINITY
        resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, limits)

    yield folder, fill


@pytest.mark.slow
@pytest.mark.parametrize("disk", [small_disk, limited_files])
def test_the_disk_is_full(
    disk: Callable[[Path], Any], app: Flask, config: Config, tmp_path: Path
) -> None:
    if not hasattr(resource, "prlimit"):
        pytest.skip("files can't be limited here")
    with disk(tmp_path / "disk") as (folder, fill):
        engine_of(app).dispose()
        database = Path(shutil.copyfile(config.database, folder / DATABASE_FILE))
        elsewhere = replace(config, database=database)
        with opened(database) as engine:
            other = create_app(elsewhere, engine)
            people = [Browser(other) for _ in range(WORKERS)]
            with running(elsewhere, tmp_path) as server:
                with traffic(server, people) as seen:
                    seen.wait_for(200)
                    fill(server, True)
                    seen.wait_for(503, 5 * WORKERS)
                    fill(server, False)
                    seen.wait_for(200, 5 * WORKERS)
                    time.sleep(outages.QUIET_S)
                    seen.wait_for(200)
                assert server.end() == 0
        check(elsewhere, server, seen, "the disk is full", "the disk can't be read or written")


def test_what_is_no_outage_stays_a_bug(app: Flask, caplog: pytest.LogCaptureFixture) -> None:
    browser = Browser(app)
    item = browser.take("describe")["item"]
    with transaction(engine_of(app)) as session:
        session.execute(text("ALTER TABLE event RENAME TO gone"))
    for _ in range(2):
        response = browser.answer(item, described())
        assert response.status_code == 500
        assert "Retry-After" not in response.headers
    (first, _) = [record for record in caplog.records if record.exc_info]
    assert "no such table" in str(first.exc_info)


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_errors_of_the_driver_are_known_by_their_kind(app: Flask) -> None:
    duplicate = text("INSERT INTO study SELECT * FROM study")
    with pytest.raises(IntegrityError) as found, transaction(engine_of(app)) as session:
        session.execute(duplicate)
    assert outage_of(found.value) is None


def test_a_database_that_cannot_be_written_to(config: Config, tmp_path: Path, app: Flask) -> None:
    file = Path(config.database)
    engine = create_engine(f"sqlite:///file:{file}?mode=ro&uri=true")

    @event.listens_for(engine, "begin")
    def begin(connection: Any) -> None:
        connection.exec_driver_sql("BEGIN IMMEDIATE")

    with pytest.raises(OperationalError) as found, engine.begin() as connection:
        connection.exec_driver_sql("DELETE FROM draft")
    engine.dispose()
    assert outage_of(found.value) == Outage(
        "the database can't be written to", "attempt to write a readonly database"
    )


def test_a_damaged_file(tmp_path: Path) -> None:
    file = tmp_path / "damaged.sqlite"
    file.write_bytes(b"This is no database. " * 1000)
    with opened(file) as engine, pytest.raises(DBAPIError, match="not a database") as found:
        engine.connect()
    known = outage_of(found.value)
    assert known is not None
    assert known.kind == "the database is damaged"


def test_the_folder_of_the_database_is_gone(app: Flask, config: Config) -> None:
    browser = Browser(app)
    item = browser.take("describe")["item"]
    folder = config.instance
    moved = folder.rename(folder.with_name("moved"))
    response = browser.answer(item, described())
    assert (response.status_code, response.headers["Retry-After"]) == (503, "10")
    moved.rename(folder)
    assert browser.answer(item, described()).status_code == 200


def test_a_file_that_was_replaced_is_left_alone(app: Flask, config: Config, tmp_path: Path) -> None:
    """As when a backup is put in the place of the database while that is served.

    SQLite would add what was written last to the one file to the other.
    """
    file, old, copy = Path(config.database), tmp_path / "old", tmp_path / "copy"
    engine_of(app).dispose()
    content = Path(shutil.copyfile(file, copy)).read_bytes()
    browser = Browser(app)
    item = browser.take("describe")["item"]
    file.rename(old)
    copy.rename(file)
    assert browser.answer(item, described()).status_code == 503
    assert file.read_bytes() == content
    old.replace(file)
    assert browser.answer(item, described()).status_code == 200


def test_all_connections_are_in_use() -> None:
    assert outage_of(NoConnectionLeft()) == Outage("all connections to the database are in use", "")
    assert outage_of(OSError(28, "No space left on device")) == Outage(
        "the disk is full", "No space left on device"
    )
    assert outage_of(FileNotFoundError(2, "No such file")) is None
    assert outage_of(ValueError("disk I/O error")) is None


def test_the_log_tells_once_a_minute_and_when_it_is_over(
    caplog: pytest.LogCaptureFixture,
) -> None:
    clock = [0.0]
    told = Outages(lambda: clock[0])
    for second in range(67):
        clock[0] = float(second)
        for _ in range(100):
            told.failed(Outage("the database can't be reached", "refused"))
        told.worked()  # what was begun before
    clock[0] = 90.0
    told.worked()
    told.worked()
    told.failed(Outage("the disk is full", ""))
    assert [record.getMessage() for record in caplog.records] == [
        "the database can't be reached (refused); it is tried again with each request",
        "the database can't be reached (refused): 6000 more times in 60 s",
        "over after 66 s: the database can't be reached (6700 times)",
        "the disk is full; it is tried again with each request",
    ]


def test_limits_that_cannot_be_counted_dont_flood_the_log(
    app: Flask, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = MemoryStorage(wrap_exceptions=True)
    monkeypatch.setattr(broken, "acquire_entry", broken_storage)
    counting = replace(installation_of(app), limiter=MovingWindowRateLimiter(broken))
    app.extensions["annotation"] = counting
    browser = Browser(app)
    item = browser.take("describe")["item"]
    for revision in range(20):
        assert browser.draft(item, revision, {"text": "Go"}).status_code == 200
    (line,) = [r for r in caplog.records if r.levelno >= logging.ERROR]
    assert "requests can't be counted" in line.getMessage()
    assert not line.exc_info


def broken_storage(*_: object, **__: object) -> bool:
    from limits.errors import StorageError  # noqa: PLC0415

    raise StorageError(ConnectionError("refused"))


def test_a_server_that_starts_without_its_database(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "corpus_tools", "annotate", "serve", "--port", "0"]
    command += ["--instance", str(tmp_path), "--database", f"postgresql://me@/x?host={tmp_path}"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    (line,) = done.stderr.splitlines()
    assert "postgresql+psycopg://me@/x?host=" in line
    assert "the database can't be reached" in line
    assert "--database" in line


def served(*options: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "corpus_tools", "annotate", *map(str, options)]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)


def test_a_server_that_starts_in_an_outage_of_its_file(config: Config, tmp_path: Path) -> None:
    """The folder of the database is missing, or the database is no database."""
    missing = tmp_path / "missing" / "x.sqlite"
    done = served("serve", "--port", 0, "--instance", config.instance, "--database", missing)
    assert (done.returncode, done.stdout) == (2, "")
    assert f"{missing}: the database can't be reached" in done.stderr
    assert "run the command again" in done.stderr
    damaged = tmp_path / "damaged.sqlite"
    damaged.write_bytes(b"This is no database. " * 1000)
    done = served("serve", "--port", 0, "--instance", config.instance, "--database", damaged)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert f"{damaged}: the database is damaged" in done.stderr
    assert "ct annotate restore" in done.stderr


def test_commands_on_a_full_disk_name_the_database(
    app: Flask, config: Config, tmp_path: Path
) -> None:
    engine_of(app).dispose()
    with small_disk(tmp_path / "disk") as (folder, fill):
        database = Path(shutil.copyfile(config.database, folder / DATABASE_FILE))
        (folder / f"{DATABASE_FILE}-turn").touch()
        with opened(database) as engine, reading(engine):
            pass
        fill(None, True)  # type: ignore[arg-type]
        place = ("--instance", config.instance, "--database", database)
        done = served("people", "invite", "--role", "admin", *place)
        assert (done.returncode, done.stdout) == (2, "")
        assert str(database) in done.stderr
        assert "unexpected" not in done.stderr
        assert "make room" in done.stderr or "check the disk" in done.stderr
        backup = folder / "backup.gz"
        done = served("backup", backup, "--without-keys", *place)
        assert done.returncode == 2
        assert "make room" in done.stderr
        assert not backup.exists()
        assert [path for path in folder.iterdir() if ".new-" in path.name] == []
