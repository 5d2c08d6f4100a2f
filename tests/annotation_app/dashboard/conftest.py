from __future__ import annotations

from collections.abc import Iterator

import msgspec
import pytest
from flask import Flask

from annotation_app.studies.study_file import StudyConfig, TaskConfig
from tests.annotation_app.conftest import STUDY

SHARED = msgspec.structs.replace(
    STUDY,
    tasks={
        **STUDY.tasks,
        "describe": TaskConfig(answers=9, practice=False),
        "segment": TaskConfig(answers=2, practice=False),
        "ground": TaskConfig(answers=2, practice=False),
        "rate": TaskConfig(answers=9, practice=False),
    },
)


@pytest.fixture
def address(app: Flask) -> Iterator[str]:
    """Where the app is served."""
    from tests.annotation_app.in_browser import serving  # noqa: PLC0415 - few tests need it

    with serving(app) as found:
        yield found


@pytest.fixture
def study() -> StudyConfig:
    """A study in which two people segment and ground each command."""
    return SHARED
