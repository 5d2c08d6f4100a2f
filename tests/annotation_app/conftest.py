from __future__ import annotations

import itertools
import shutil
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import pytest
from flask import Flask
from jinja2.bccache import Bucket, BytecodeCache
from sqlalchemy import Engine, create_engine, text
from sqlalchemy.engine import make_url
from sqlalchemy.orm import Mapper
from sqlalchemy.util import LRUCache
from werkzeug.routing import Rule

from annotation_app.core.config import DATABASE_FILE, Config, open_instance
from annotation_app.people import accounts
from annotation_app.serving.factory import create_app
from annotation_app.store import database as databases
from annotation_app.store.database import opened, transaction
from annotation_app.store.schema import migrate
from annotation_app.studies.study_file import KnownCommand, StudyConfig, TaskConfig
from annotation_app.study_setup.rendered_study import put_study, rendered_videos
from tests.annotation_app.postgres import cluster
from tests.annotation_app.rendered import VIDEOS, render

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext

PATIENCE_MS = 60_000

_numbers = itertools.count()

NO_PRACTICE = TaskConfig(practice=False)


def study_of(**tasks: TaskConfig) -> StudyConfig:
    """A study with these tasks, for people who don't wait until a video ends."""
    return StudyConfig(name="tests", title="A study", tasks=tasks, watching="flagged")


STUDY = StudyConfig(
    name="tests",
    title="A study",
    tasks={
        "describe": TaskConfig(answers=2, lease_minutes=10, practice=False),
        "segment": NO_PRACTICE,
        "ground": NO_PRACTICE,
        "check": NO_PRACTICE,
        "rate": TaskConfig(answers=2, practice=False),
    },
    watching="flagged",  # who sends answers by program plays no videos
    attention_checks=0.5,
    known_commands=(KnownCommand("Wait here.", VIDEOS[0], VIDEOS[1]),),
)


@pytest.fixture(scope="session")
def videos(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return render(tmp_path_factory.mktemp("videos"))


class Statements(LRUCache[Any, Any]):
    """Compiled statements, for all engines of a kind."""

    def get(self, key: Any, default: Any = None) -> Any:
        return super().get(self._for_all(key), default)

    def __setitem__(self, key: Any, compiled: Any) -> None:
        super().__setitem__(self._for_all(key), compiled)

    def _for_all(self, key: Any) -> Any:
        dialect, *rest = key
        return type(dialect), dialect.server_version_info, dialect._json_deserializer, *rest


class Templates(BytecodeCache):
    """Compiled templates, for all apps."""

    def __init__(self) -> None:
        self._codes: dict[tuple[str, str], Any] = {}

    def load_bytecode(self, bucket: Bucket) -> None:
        bucket.code = self._codes.get((bucket.key, bucket.checksum))

    def dump_bytecode(self, bucket: Bucket) -> None:
        self._codes[bucket.key, bucket.checksum] = bucket.code


@pytest.fixture(scope="session", autouse=True)
def shortcuts() -> Iterator[None]:
    """Hash passwords in no time, and compile everything once for all apps of the tests."""
    compiled: dict[object, Any] = {}
    compile_builder = Rule._compile_builder

    def compile_once(rule: Rule, append_unknown: bool = True) -> Any:
        key = (rule.rule, tuple((rule.defaults or {}).items()), append_unknown)
        if key not in compiled:
            compiled[key] = compile_builder(rule, append_unknown)
        return compiled[key]

    statements = Statements(2000)

    def engine_that_shares(*arguments: Any, **options: Any) -> Engine:
        engine = create_engine(*arguments, **options)
        engine._compiled_cache = statements
        return engine

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(databases, "create_engine", engine_that_shares)
        patch.setattr(Mapper, "_compiled_cache", statements)
        patch.setitem(Flask.jinja_options, "bytecode_cache", Templates())
        patch.setattr(accounts, "_METHOD", "scrypt:128:8:1")
        patch.setattr(accounts, "_NOBODY", accounts._NOBODY.replace("32768", "128"))
        patch.setattr(Rule, "_compile_builder", compile_once)
        yield


@pytest.fixture(scope="session")
def postgres() -> Iterator[str]:
    with cluster() as url:
        yield url


@pytest.fixture
def kind() -> str:
    """Which database; tests that are about databases are run with others too."""
    return "sqlite"


@pytest.fixture
def other_database(kind: str, request: pytest.FixtureRequest) -> str | None:
    """An empty database beside the app's, of its kind; None means a file in the instance."""
    return new_database(request.getfixturevalue("postgres")) if kind == "postgresql" else None


@pytest.fixture
def study() -> StudyConfig:
    """The app's study."""
    return STUDY


@pytest.fixture(scope="session")
def templates(
    videos: Path, tmp_path_factory: pytest.TempPathFactory
) -> Callable[[StudyConfig, str | None], str | Path]:
    """Makes a database with a study, in a cluster or a file, when it is asked for it first."""
    made: dict[tuple[str, str | None], str | Path] = {}

    def template(study: StudyConfig, server: str | None) -> str | Path:
        key = repr(study), server
        if key not in made:
            file = tmp_path_factory.mktemp("template") / DATABASE_FILE
            made[key] = new_database(server) if server else file
            set_up(made[key], study, videos)
        return made[key]

    return template


@pytest.fixture
def config(
    request: pytest.FixtureRequest,
    tmp_path: Path,
    kind: str,
    study: StudyConfig,
    templates: Callable[[StudyConfig, str | None], str | Path],
) -> Config:
    """An installation with a new database: that of the app, if there is one, or an empty one."""
    made = replace(open_instance(tmp_path / "instance"), rate_limits=False)
    server = request.getfixturevalue("postgres") if kind == "postgresql" else None
    template = templates(study, server) if "app" in request.fixturenames else None
    if server:
        return replace(made, database=new_database(server, template))
    if template:
        shutil.copyfile(template, made.database)
    return made


@pytest.fixture
def empty(config: Config) -> Iterator[Engine]:
    """A new database without a study."""
    put_tables(config.database)
    with opened(config.database) as engine:
        yield engine


@pytest.fixture
def app(config: Config) -> Iterator[Flask]:
    """An app with a study."""
    with opened(config.database) as engine:
        yield create_app(config, engine)


@pytest.fixture
def set_clock(monkeypatch: pytest.MonkeyPatch) -> Callable[[float], None]:
    """Sets the machine's clock forward or back from now, as far as Python is concerned."""
    real = time.time

    def jump(by_s: float) -> None:
        monkeypatch.setattr(time, "time", lambda: real() + by_s)

    return jump


@pytest.fixture(scope="module")  # while Playwright runs, asyncio can't be used by other tests
def browser(request: pytest.FixtureRequest) -> Iterator[Browser]:
    """Chromium; tests with the mark ``firefox`` also run in Firefox, where it is installed."""
    from tests.annotation_app.in_browser import launched  # noqa: PLC0415 - few tests need it

    with launched(getattr(request, "param", "chromium")) as made:
        yield made


@pytest.fixture(scope="module")
def chromium(browser: Browser) -> Browser:
    """The same, for tests that most often run in Chromium."""
    return browser


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    if "browser" in metafunc.fixturenames and metafunc.definition.get_closest_marker("firefox"):
        kinds = ["chromium", "firefox"]
        metafunc.parametrize("browser", kinds, indirect=True, scope="module")


@pytest.fixture
def context(browser: Browser) -> Iterator[BrowserContext]:
    """A new user's browser."""
    # What a service worker asks for isn't seen by tests that hold requests up.
    made = browser.new_context(viewport={"width": 1280, "height": 900}, service_workers="block")
    made.set_default_timeout(PATIENCE_MS)
    yield made
    made.close()


@cache
def _tables() -> bytes:
    """A database file without a study."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / DATABASE_FILE
        with opened(file) as engine:
            migrate(engine)
        return file.read_bytes()


def put_tables(database: str | Path) -> None:
    """Make a database's tables, if it is new."""
    if isinstance(database, str):
        with opened(database) as engine:
            migrate(engine)
    elif not database.exists():
        database.touch(mode=0o600)
        database.write_bytes(_tables())


def set_up(database: str | Path, study: StudyConfig, videos: Path) -> None:
    """Put a study into a new database."""
    put_tables(database)
    with opened(database) as engine, transaction(engine) as session:
        put_study(session, study, rendered_videos(videos))


def new_database(url: str, template: str | Path | None = None) -> str:
    """The URL of a new database in a cluster, empty or a copy of another one."""
    name = f"test{next(_numbers)}"
    server = create_engine(
        url.format(name="postgres").replace("postgresql:", "postgresql+psycopg:"),
        isolation_level="AUTOCOMMIT",
    )
    like = make_url(str(template)).database if template else "template1"
    with server.connect() as connection:
        connection.execute(text(f"CREATE DATABASE {name} TEMPLATE {like}"))
    server.dispose()
    return url.format(name=name)
