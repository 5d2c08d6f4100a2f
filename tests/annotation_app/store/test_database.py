"""Connections that the server has closed meanwhile, and what readers see."""

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


def test_who_reads_sees_what_has_come_since_or_one_state(config: Config) -> None:
    with opened(config.database) as engine:
        with transaction(engine) as session:
            session.execute(text("CREATE TABLE seen (at INTEGER)"))
        for one_state in (False, True):
            with reading(engine, one_state=one_state) as session:
                before = session.scalar(text("SELECT count(*) FROM seen"))
                with transaction(engine) as other:
                    other.execute(text("INSERT INTO seen VALUES (1)"))
                after = session.scalar(text("SELECT count(*) FROM seen"))
            assert after - before == (0 if one_state else 1)
