from __future__ import annotations

import pytest
from flask import Flask

from annotation_app.core.config import Config
from tests.annotation_app.crowds.crowd_worker import Lab, external_url
from tests.annotation_app.crowds.mturk.turkers import participations, work, worker
from tests.annotation_app.crowds.stand_ins import MechanicalTurk


@pytest.fixture
def lab(config: Config, mturk: MechanicalTurk) -> Lab:
    return Lab(config, mturk.address)


@pytest.fixture
def address(app: Flask, lab: Lab, mturk: MechanicalTurk) -> str:
    """Where workers come in for two descriptions each."""
    result = lab.publish("--task", "describe", "--items", "2", "--people", "5", "--sandbox")
    assert result.exit_code == 0, result.output
    (hit,) = mturk.hits.values()
    return external_url(hit["Question"])


@pytest.fixture
def sent(app: Flask, address: str, mturk: MechanicalTurk) -> str:
    """An assignment that somebody has done and sent in."""
    one = worker(app, address, mturk)
    work(one)
    one.submit(mturk)
    (mine,) = participations(app)
    return mine.assignment
