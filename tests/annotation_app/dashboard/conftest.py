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
from annotation_app.study import TaskConfig
from tests.annotation_app.conftest import STUDY

SHARED = msgspec.structs.replace(
    STUDY,
    tasks={
        **STUDY.tasks,
        "describe": TaskConfig(answers=9),
        "segment": TaskConfig(answers=2),
        "ground": TaskConfig(answers=2),
        "rate": TaskConfig(answers=9),
    },
)


@pytest.fixture
def app(config: Config, videos: Path) -> Iterator[Flask]:
    """An app with a study in which two people segment and ground each command."""
    engine = open_database(config.database)
    migrate(engine)
    with transaction(engine) as session:
        put_study(session, SHARED, rendered_videos(videos))
    yield create_app(config, engine)
    engine.dispose()
