"""Some days after a study was closed its answers are nobody's any more."""

from __future__ import annotations

import json
import time
from typing import Any

import msgspec
import pytest
from flask import Flask
from sqlalchemy import select, update

from annotation_app.export.corpus_export import export_corpus
from annotation_app.people.accounts import add_login
from annotation_app.people.participants import find_or_add, keep_consent, subject_of
from annotation_app.privacy.retention import DAY_S, expire
from annotation_app.serving import server as serving
from annotation_app.store.database import reading, transaction
from annotation_app.store.models import (
    Answer,
    AuditEntry,
    Draft,
    LedgerEntry,
    Participation,
    Person,
    Study,
)
from annotation_app.studies.study_file import StudyConfig
from annotation_app.work.handing_out import find_study
from corpus_tools.cli.console import run
from tests.annotation_app.browser import (
    Browser,
    described,
    engine_of,
    execute,
    installation_of,
    rows_in,
)
from tests.annotation_app.conftest import STUDY
from tests.annotation_app.privacy.test_erasure import (
    code_of,
    command,
    everything,
    participation,
    pay,
)

UNLINKED = "unlinked from people"

pytestmark = pytest.mark.parametrize("kind", ["sqlite", "postgresql"])


@pytest.fixture
def study() -> StudyConfig:
    return msgspec.structs.replace(STUDY, retention_days=30)


def close(app: Flask, *, days_ago: float, name: str = "tests") -> None:
    closed_at = time.time() - days_ago * DAY_S
    execute(app, update(Study).where(Study.name == name).values(closed_at=closed_at))


def other_study(app: Flask, *people: Browser) -> None:
    """Another study, which goes on, in which people take part."""
    with transaction(engine_of(app)) as session:
        config = find_study(session, "tests").config
        study = Study(id="other", name="other", config=config, created_at=time.time())
        session.add(study)
        session.flush()
        for one in people:
            keep_consent(session.get_one(Person, one.person.id), study.id, {"age": "88"})


def test_answers_stay_and_people_go(app: Flask) -> None:
    ada, bob = Browser(app), Browser(app)
    with app.app_context(), transaction(engine_of(app)) as session:
        tests = find_study(session, "tests")
        keep_consent(session.get_one(Person, ada.person.id), tests.id, {"age": "thirty-seven"})
        keep_consent(session.get_one(Person, bob.person.id), tests.id, {"age": "forty"})
        staff = add_login(session, "maria", "admin", "correct horse", actor="tests").id
        came = find_or_add(session, "prolific", "5f1c0a").id
    other_study(app, bob)
    for one in (ada, bob):
        one.do("describe", described())
        one.draft(one.take("describe")["item"], 1, {"text": "My name is"})
    with transaction(engine_of(app)) as session:
        tests = find_study(session, "tests")
        for number, who in enumerate((ada.person.id, came)):
            person = session.get_one(Person, who)
            pay(session, tests, participation(session, tests, person, f"paid {number}"))
            participation(session, tests, person, f"not paid {number}")
    code = code_of(app, ada)
    before = ada.person.external_hash
    close(app, days_ago=29)
    serving.prepare(installation_of(app).config)
    assert "thirty-seven" in everything(app)
    close(app, days_ago=31)
    with reading(engine_of(app)) as session:
        corpus = export_corpus(session, find_study(session, "tests"))

    serving.prepare(installation_of(app).config)
    left = everything(app)
    for gone in ("thirty-seven", "forty", "My name is", "not paid", code, before):
        assert gone not in left
    with reading(engine_of(app)) as session:
        assert session.scalars(select(Draft)).all() == []
        person = session.get_one(Person, ada.person.id)
        assert (person.provider, person.session_number) == ("erased", 2)
        # Bob goes on elsewhere, and whoever has a login keeps it.
        assert session.get_one(Person, bob.person.id).profile["answers"] == {"other": {"age": "88"}}
        assert session.get_one(Person, bob.person.id).provider == "test"
        assert session.get_one(Person, staff).login == "maria"
        after = export_corpus(session, find_study(session, "tests"))
        assert [c.text for c in after.commands.values()] == [
            c.text for c in corpus.commands.values()
        ]
        # Who typed the same command twice is still one person, and nobody knows who.
        assert subject_of(person) in {c.subject for c in after.commands.values()}
        assert before[:12] not in {c.subject for c in after.commands.values()}
        paid = session.scalars(select(Participation).order_by(Participation.assignment)).all()
        assert [one.assignment for one in paid] == ["paid 0", "paid 1"]
        assert len(session.scalars(select(LedgerEntry)).all()) == 2
        answered = set(session.scalars(select(Answer.person_id)))
        assert not answered & {one.person_id for one in paid}
        (entry,) = session.scalars(select(AuditEntry).where(AuditEntry.action == UNLINKED))
        assert entry.about == "tests"

    assert expire(engine_of(app), now=time.time()) == []
    serving.prepare(installation_of(app).config)
    assert len(rows_in(app, select(AuditEntry).where(AuditEntry.action == UNLINKED))) == 1
    close(app, days_ago=31, name="other")
    (done,) = expire(engine_of(app), now=time.time())
    assert (done.study, done.people) == ("other", 1)


def test_from_the_command_line(app: Flask, capsys: Any) -> None:
    Browser(app).do("describe", described())
    erase = ["people", "erase", "--expired", "--json"]
    assert run(command(app, *erase)) == 0
    assert json.loads(capsys.readouterr().out)["studies"] == []
    close(app, days_ago=31)
    before = everything(app)
    for given in (["--dry-run"], ["--dry-run", "--study", "tests"]):
        assert run(command(app, *erase, *given)) == 0
        told = json.loads(capsys.readouterr().out)
        assert (told["erased"], told["studies"][0]["people"]) == (False, 1)
    assert everything(app) == before
    assert run(command(app, *erase, "--study", "another")) == 0
    assert json.loads(capsys.readouterr().out)["studies"] == []
    assert run(command(app, *erase)) == 0
    assert json.loads(capsys.readouterr().out)["erased"] is True
    assert run(command(app, *erase)) == 0
    assert json.loads(capsys.readouterr().out)["studies"] == []
