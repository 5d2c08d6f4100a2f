from __future__ import annotations

from collections.abc import Iterator

import msgspec
import pytest
from flask import Flask

from annotation_app.core.config import Config
from annotation_app.studies.study_file import Payment, StudyConfig, TaskConfig
from tests.annotation_app.conftest import STUDY
from tests.annotation_app.crowds.crowd_worker import Lab
from tests.annotation_app.crowds.prolific_stand_in import Prolific
from tests.annotation_app.crowds.stand_ins import MechanicalTurk, serving

PAID = msgspec.structs.replace(
    STUDY,
    tasks={**STUDY.tasks, "describe": TaskConfig(answers=9, practice=False)},
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
def study() -> StudyConfig:
    """A study that pays ten cents an item."""
    return PAID


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


@pytest.fixture
def lab(app: Flask, config: Config, prolific: Prolific) -> Lab:
    """A researcher who offers work by Prolific."""
    return Lab(config, prolific.address, "prolific")  # type: ignore[attr-defined]
