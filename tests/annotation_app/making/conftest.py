from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from flask import Flask

from annotation_app.core.config import open_instance
from annotation_app.serving import server
from annotation_app.serving.factory import create_app
from annotation_app.store.database import opened
from tests.annotation_app.conftest import put_tables
from tests.annotation_app.signing_in import Member, signed_in
from tests.annotation_app.study_setup.clips import clip


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """A folder of studies with a folder of three videos."""
    for name, shade in (("push", 40), ("lift", 140), ("wait", 90)):
        clip(tmp_path / f"studies/clips/{name}.mp4", shade)
    return tmp_path / "studies"


@pytest.fixture
def app(tmp_path: Path, root: Path) -> Iterator[Flask]:
    """An app without a study."""
    config = replace(open_instance(tmp_path / "instance"), rate_limits=False, studies=root)
    put_tables(config.database)
    server.prepare(config)
    with opened(config.database) as engine:
        yield create_app(config, engine)


@pytest.fixture
def admin(app: Flask) -> Member:
    return signed_in(app, "ada", "admin")
