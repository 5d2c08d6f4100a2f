"""What migrations make of the rows that they find."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
from flask import Flask
from sqlalchemy import Engine, text

from annotation_app.store.database import opened
from annotation_app.store.schema import is_current, migrate
from g3.errors import FormatError
from tests.annotation_app.browser import Browser, described, installation_of, rows_in
from tests.annotation_app.old_installations import old_installation


def kinds(engine: Engine) -> Counter[str]:
    return Counter(rows_in(engine, text("SELECT kind FROM answer")))


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_answers_to_attention_checks_are_renamed(
    app: Flask, tmp_path: Path, other_database: str | None
) -> None:
    for author in (Browser(app), Browser(app)):
        author.do("describe", described())
    rater = Browser(app)
    while rater.lease("rate").status_code == 200:
        rater.do("rate", {"rating": 4, "watched_s": 900.0})
    old = old_installation(installation_of(app).config, tmp_path / "old", other_database)
    with opened(old.database) as engine:
        migrate(engine, "0009")
        before = kinds(engine)
        assert before["check"] > 0
        migrate(engine)
        assert is_current(engine)
        found = kinds(engine)
    assert found == {"attention": before["check"], "usual": before["usual"]}
    assert found == kinds(installation_of(app).engine)


def test_a_database_from_before_the_first_release_is_refused(app: Flask) -> None:
    engine = installation_of(app).engine
    with engine.begin() as connection:
        connection.exec_driver_sql("UPDATE alembic_version SET version_num = '0005'")
    with pytest.raises(FormatError, match=r"before version 0\.2\.0"):
        migrate(engine)
