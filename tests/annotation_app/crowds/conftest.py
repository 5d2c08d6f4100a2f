from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest
from flask import Flask

from annotation_app.config import Config
from annotation_app.database import open_database, transaction
from annotation_app.factory import create_app
from annotation_app.schema import migrate
from annotation_app.setup import put_study, rendered_videos
from annotation_app.study import Payment, TaskConfig
from tests.annotation_app.conftest import STUDY
from tests.annotation_app.crowds.stand_ins import MechanicalTurk, Prolific, serving

PAID = msgspec.structs.replace(
    STUDY,
    tasks={**STUDY.tasks, "describe": TaskConfig(answers=9)},
    payment=Payment(0.10),
    attention_checks=0.0,
    known_commands=(),
)


@pytest.fixture(autouse=True)
def credentials(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "test")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "test")
    monkeypatch.setenv("AWS_EC2_METADATA_DISABLED", "true")
    monkeypatch.setenv("PROLIFIC_TOKEN", "secret")
    monkeypatch.delenv("PROLIFIC_PROJECT", raising=False)


@pytest.fixture
def app(config: Config, videos: Path) -> Iterator[Flask]:
    """An app with a study that pays ten cents an item."""
    engine = open_database(config.database)
    migrate(engine)
    with transaction(engine) as session:
        put_study(session, PAID, rendered_videos(videos))
    yield create_app(config, engine)
    engine.dispose()


@pytest.fixture
def mturk() -> Iterator[MechanicalTurk]:
    platform = MechanicalTurk()
    with serving(platform) as platform.address:  # type: ignore[attr-defined]
        yield platform


@pytest.fixture
def prolific() -> Iterator[Prolific]:
    platform = Prolific()
    with serving(platform) as platform.address:  # type: ignore[attr-defined]
        yield platform
