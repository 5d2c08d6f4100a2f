from __future__ import annotations

import msgspec
import pytest

from annotation_app.studies.study_file import StudyConfig, TaskConfig
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
def study() -> StudyConfig:
    """A study in which two people segment and ground each command."""
    return SHARED
