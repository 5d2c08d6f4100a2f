"""Connections to PostgreSQL that the server has closed meanwhile."""

from __future__ import annotations

import pytest
from sqlalchemy import create_engine, select, text

from annotation_app.core.config import Config
from annotation_app.store import database
from annotation_app.store.database import opened, reading, transaction


@pytest.mark.parametrize("kind", ["postgresql"])
def test_a_connection_that_was_idle_is_replaced(
    config: Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(database, "IDLE_S", 0)
    other = create_engine(str(config.database).replace("postgresql:", "postgresql+psycopg:"))
    with opened(config.database) as engine:
        for session_of in (reading, transaction):
            with session_of(engine) as session:
                assert session.scalar(select(text("1"))) == 1
            with other.begin() as connection:
                connection.execute(
                    text(
                        "SELECT pg_terminate_backend(pid) FROM pg_stat_activity "
                        "WHERE datname = current_database() AND pid <> pg_backend_pid()"
                    )
                )
        with reading(engine) as session:
            assert session.scalar(select(text("1"))) == 1
    other.dispose()
