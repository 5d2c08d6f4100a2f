from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from flask import Flask
from sqlalchemy import create_engine, text

from annotation_app.config import Config, open_instance
from annotation_app.database import open_database, transaction
from annotation_app.factory import create_app
from annotation_app.schema import migrate
from annotation_app.setup import put_study, rendered_videos
from annotation_app.study import KnownCommand, StudyConfig, TaskConfig
from tests.annotation_app.postgres import cluster
from tests.annotation_app.rendered import VIDEOS, render

_numbers = itertools.count()

STUDY = StudyConfig(
    name="tests",
    title="A study",
    tasks={
        "describe": TaskConfig(answers=2, lease_minutes=10),
        "segment": TaskConfig(),
        "ground": TaskConfig(),
        "check": TaskConfig(),
        "rate": TaskConfig(answers=2),
    },
    attention_checks=0.5,
    known_commands=(KnownCommand("Wait here.", VIDEOS[0], VIDEOS[1]),),
)


@pytest.fixture(scope="session")
def videos(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return render(tmp_path_factory.mktemp("videos"))


@pytest.fixture(scope="session")
def postgres() -> Iterator[str]:
    with cluster() as url:
        yield url


@pytest.fixture
def kind() -> str:
    """Which database; tests that are about databases are run with others too."""
    return "sqlite"


@pytest.fixture
def config(request: pytest.FixtureRequest, tmp_path: Path, kind: str) -> Config:
    """An installation with a new database."""
    made = replace(open_instance(tmp_path / "instance"), rate_limits=False)
    if kind == "postgresql":
        made = replace(made, database=new_database(request.getfixturevalue("postgres")))
    return made


@pytest.fixture
def app(config: Config, videos: Path) -> Iterator[Flask]:
    """An app with a study of all five tasks."""
    engine = open_database(config.database)
    migrate(engine)
    with transaction(engine) as session:
        put_study(session, STUDY, rendered_videos(videos))
    yield create_app(config, engine)
    engine.dispose()


def new_database(url: str) -> str:
    """The URL of a new, empty database in a cluster."""
    name = f"test{next(_numbers)}"
    server = create_engine(
        url.format(name="postgres").replace("postgresql:", "postgresql+psycopg:"),
        isolation_level="AUTOCOMMIT",
    )
    with server.connect() as connection:
        connection.execute(text(f"CREATE DATABASE {name}"))
    server.dispose()
    return url.format(name=name)
