"""Backups, restoring, and bringing older databases up to date."""

from __future__ import annotations

import stat
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from flask import Flask
from sqlalchemy import Engine, select
from sqlalchemy.exc import IntegrityError

from annotation_app.copies.backups import back_up
from annotation_app.copies.restoring import restore
from annotation_app.core.config import Config, open_instance
from annotation_app.people.participants import add_anonymous
from annotation_app.serving import server as serving
from annotation_app.serving.factory import create_app
from annotation_app.store import migrating
from annotation_app.store.audit import RESTORED
from annotation_app.store.database import opened, reading, transaction
from annotation_app.store.models import AuditEntry, Base, Person
from annotation_app.store.schema import NEWEST, migrate
from g3.errors import FormatError
from tests.annotation_app.browser import Browser, described, engine_of, installation_of
from tests.annotation_app.conftest import new_database

pytestmark = pytest.mark.parametrize("kind", ["sqlite", "postgresql"])

PASSPHRASE = "correct horse battery"


def rows(config: Config) -> dict[str, list[object]]:
    """All rows of a database, but for the mark that it was restored."""
    with opened(config.database) as engine, reading(engine) as session:
        all_rows = {
            table.name: sorted(map(repr, session.execute(select(table)).all()))
            for table in Base.metadata.sorted_tables
        }
    unmarked = [row for row in all_rows["audit"] if RESTORED not in row]
    return {**all_rows, "audit": unmarked}


@pytest.mark.parametrize("other", ["sqlite", "postgresql"])
def test_a_backup_can_be_restored_into_any_database(
    app: Flask, other: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    person = Browser(app)
    item = person.take("describe")["item"]
    person.draft(item, 1, {"text": "Go 😀"})
    Browser(app).do("describe", described("Go away"))
    config = installation_of(app).config
    archive = tmp_path / "backup.gz"
    count = back_up(config, archive, PASSPHRASE)
    assert stat.S_IMODE(archive.stat().st_mode) == 0o600

    url = new_database(request.getfixturevalue("postgres")) if other == "postgresql" else None
    done = restore(archive, tmp_path / "restored", url, passphrase=PASSPHRASE)
    assert done.contents.rows == count
    restored = open_instance(tmp_path / "restored", url)
    assert rows(restored) == rows(config)
    with opened(restored.database) as engine, reading(engine) as session:
        assert [entry.action for entry in session.scalars(select(AuditEntry))][-1:] == [RESTORED]
    assert (restored.secret_key, restored.salt) == (config.secret_key, config.salt)

    with opened(restored.database) as engine:
        again = create_app(restored, engine)
        assert person.client.get(f"/api/items/{item}").status_code == 200
        with again.app_context(), transaction(engine) as session:
            add_anonymous(session)
        Browser(again).do("describe", described("Go on"))


def test_a_backup_goes_into_nothing_but_an_empty_database(app: Flask, tmp_path: Path) -> None:
    config = installation_of(app).config
    archive = tmp_path / "backup.gz"
    back_up(config, archive, PASSPHRASE)
    with pytest.raises(FormatError, match="instance already"):
        restore(archive, config.instance, passphrase=PASSPHRASE)
    url = str(config.database)
    url = url if "://" in url else f"sqlite:///{url}"
    with pytest.raises(FormatError, match="isn't empty"):
        restore(archive, tmp_path / "other", url, passphrase=PASSPHRASE)
    assert not (tmp_path / "other").exists()


def test_migrations_make_what_the_models_say(empty: Engine) -> None:
    with empty.connect() as connection:
        context = MigrationContext.configure(connection)
        assert context.get_current_revision() == NEWEST
        assert compare_metadata(context, Base.metadata) == []


@pytest.mark.slow
def test_several_processes_may_start_at_once_on_an_empty_database(config: Config) -> None:
    context = get_context("forkserver")  # reads the modules once
    context.set_forkserver_preload([serving.__name__, migrating.__name__])
    with ProcessPoolExecutor(4, mp_context=context) as pool:
        for started in [pool.submit(serving.prepare, config) for _ in range(4)]:
            started.result()
        told = [pool.submit(serving.addresses, config, "http://localhost") for _ in range(8)]
        assert len({address for start in told for _, address in start.result()}) == 8
    assert len(rows(config)["secret"]) == 1
    assert len(rows(config)["account_link"]) == 8


LATER = """
import sqlalchemy as sa
from alembic import op

revision, down_revision = "later", "{head}"
branch_labels = depends_on = None


def upgrade():
    with op.batch_alter_table("item") as table:
        table.add_column(sa.Column("note", sa.String(20), nullable=False, server_default="none"))
        table.alter_column("subject", type_=sa.String(600))
    op.create_index("ix_answer_task", "answer", ["task"])
"""


def test_a_later_migration_changes_a_filled_database(app: Flask, tmp_path: Path) -> None:
    """Also of a table that others refer to."""
    person = Browser(app)
    person.do("describe", described("Go there 😀"))
    person.draft(person.take("describe")["item"], 1, {"text": "Go"})
    config, engine = installation_of(app).config, engine_of(app)
    before = rows(config)
    (tmp_path / "later.py").write_text(LATER.format(head=NEWEST))
    migrate(engine, scripts=[tmp_path])
    assert rows(config) == before
    with engine.connect() as connection:
        assert set(connection.exec_driver_sql("SELECT note FROM item").scalars()) == {"none"}
        if engine.dialect.name == "sqlite":
            assert connection.exec_driver_sql("PRAGMA foreign_keys").scalar() == 1
    with pytest.raises(IntegrityError), engine.begin() as connection:
        connection.exec_driver_sql("DELETE FROM item")


def test_a_newer_programs_database_is_refused(app: Flask) -> None:
    engine = engine_of(app)
    with engine.begin() as connection:
        connection.exec_driver_sql("UPDATE alembic_version SET version_num = '9999'")
    with pytest.raises(FormatError, match="not one that this program knows"):
        migrate(engine)
    with pytest.raises(FormatError, match="not set up"):
        create_app(installation_of(app).config, engine)
    with engine.connect() as connection:
        assert connection.execute(select(Person)).all() == []
