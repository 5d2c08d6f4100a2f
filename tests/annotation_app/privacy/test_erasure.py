"""Erasing a person's data: from the database, its files, exports, and backups that come back."""

from __future__ import annotations

import itertools
import json
import stat
import time
from pathlib import Path
from typing import Any

import pytest
from flask import Flask
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sqlalchemy import func, select

from annotation_app.export.corpus_export import export_corpus
from annotation_app.people.accounts import add_login, matching
from annotation_app.people.participants import find_or_add, keep_consent, subject_of
from annotation_app.privacy import erasure
from annotation_app.serving import server as serving
from annotation_app.store.database import reading, transaction
from annotation_app.store.models import (
    Answer,
    AuditEntry,
    Base,
    Event,
    Item,
    LedgerEntry,
    Participation,
    Person,
    Slot,
    Study,
)
from annotation_app.store.tombstones import ERASED_FILE, read_tombstones
from annotation_app.work.handing_out import find_study
from corpus_tools.cli.console import run
from g3.sdc.sdc_notation import parse_brackets, to_json
from tests.annotation_app.browser import (
    Browser,
    described,
    engine_of,
    installation_of,
    row_in,
    rows_in,
)
from tests.annotation_app.work.test_adoption import grounded

ADAS = "Pick up the zebra crate"
TREE = "EVENT(r = Pick up, l = OBJ(f = the {0}))"
BOTH = pytest.mark.parametrize("kind", ["sqlite", "postgresql"])


def sdcs(page: dict[str, Any]) -> Any:
    command = page["payload"]["command"]
    return to_json(parse_brackets(TREE.format(command[len("Pick up the ") :]), command=command))


def segment(person: Browser) -> None:
    page = person.take("segment")
    assert person.answer(page["item"], {"sdcs": sdcs(page)}).status_code == 200


def ground(person: Browser) -> None:
    page = person.take("ground")
    assert person.answer(page["item"], grounded(page)).status_code == 200


def check(person: Browser) -> None:
    page = person.take("check")
    verdicts = {str(clause["node"]): False for clause in page["payload"]["clauses"]}
    assert person.answer(page["item"], {"verdicts": verdicts}).status_code == 200


def counts(app: Flask) -> dict[str, int]:
    return {
        str(table.name): row_in(app, select(func.count()).select_from(table)) or 0
        for table in Base.metadata.sorted_tables
    }


def everything(app: Flask) -> str:
    """All that the database holds, as text."""
    with reading(engine_of(app)) as session:
        return "\n".join(
            repr(row)
            for table in Base.metadata.sorted_tables
            for row in session.execute(select(table))
        )


def code_of(app: Flask, person: Browser) -> str:
    with reading(engine_of(app)) as session:
        code = session.get_one(Person, person.person.id).code
    assert code is not None
    return code


def command(app: Flask, *arguments: str) -> list[str]:
    config = installation_of(app).config
    database = ["--database", str(config.database)] if "://" in str(config.database) else []
    return ["annotate", *arguments, "--instance", str(config.instance), *database]


@pytest.fixture
def worked(app: Flask) -> tuple[Browser, Browser]:
    """Ada has typed a command and a draft; Bob has typed one, and worked on hers and on his."""
    ada, bob = Browser(app), Browser(app)
    with transaction(engine_of(app)) as session:
        study = find_study(session, "tests")
        keep_consent(session.get_one(Person, ada.person.id), study.id, {"age": "thirty-seven"})
    ada.do("describe", described(ADAS))
    bob.do("describe", described("Pick up the lamp"))
    ada.draft(ada.take("describe")["item"], 1, {"text": "My name is Ada Zebra"})
    for _ in range(2):
        segment(bob)
        ground(bob)
        check(bob)
    for _ in range(3):
        bob.lease("rate")
        bob.do("rate", {"rating": 4, "watched_s": 1.0})
    return ada, bob


@BOTH
def test_nothing_is_left_of_somebody(
    app: Flask, worked: tuple[Browser, Browser], tmp_path: Path, capsys: Any
) -> None:
    ada, _ = worked
    code = code_of(app, ada)
    assert "zebra" in everything(app)
    dry = command(app, "people", "erase", code.lower().replace("-", " "), "--dry-run", "--json")
    before = counts(app)
    capsys.readouterr()
    assert run(dry) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["answers"], told["drafts"], told["erased"]) == (1, 1, False)
    # To segment, twice to rate, to ground, to check; Bob has answered all but Ada's own video.
    assert told["items_made_of_them"] == 5
    assert counts(app) == before
    assert run(command(app, "people", "erase", code)) == 2  # nobody is there to say yes
    assert "--yes" in capsys.readouterr().err
    assert counts(app) == before

    assert run(command(app, "people", "erase", code, "--yes")) == 0
    capsys.readouterr()
    left = everything(app)
    for word in ("zebra", "Zebra", "thirty-seven", code):
        assert word not in left
    with reading(engine_of(app)) as session:
        person = session.get_one(Person, ada.person.id)
        assert person.external_hash != ada.person.external_hash
        assert (person.provider, person.profile, person.code) == ("erased", {}, None)
        assert person.session_number == 2
        assert session.scalars(select(Answer).where(Answer.person_id == person.id)).all() == []
        texts = [
            answer.body["text"]
            for answer in session.scalars(select(Answer).where(Answer.task == "describe"))
        ]
        assert texts == ["Pick up the lamp"]
        corpus = export_corpus(session, find_study(session, "tests"))
        assert [c.text for c in corpus.commands.values()] == texts
        assert len(corpus.annotations) == 2
        (entry,) = session.scalars(select(AuditEntry))
        assert (entry.actor, entry.about) == ("command line", person.id)
        assert entry.details["answers"] == 1
        assert subject_of(ada.person) not in repr(entry.details)
    assert run(command(app, "people", "erase", code, "--yes")) == 2  # there is nobody any more
    file = installation_of(app).config.instance / ERASED_FILE
    assert [t.person for t in read_tombstones(file)] == [ada.person.id]
    assert stat.S_IMODE(file.stat().st_mode) == 0o600


def test_the_databases_files_hold_it_no_more(app: Flask, worked: tuple[Browser, Browser]) -> None:
    ada, _ = worked
    folder = installation_of(app).config.instance

    def held() -> list[str]:
        return [f.name for f in folder.iterdir() if f.is_file() and b"zebra" in f.read_bytes()]

    assert held()
    engine_of(app).dispose()  # as by a command of its own
    assert run(command(app, "people", "erase", code_of(app, ada), "--yes")) == 0
    assert held() == []


def test_what_others_keep_from_being_compacted_is_later(
    app: Flask, worked: tuple[Browser, Browser], capsys: Any
) -> None:
    """Somebody reads all the time; at the next start nobody does."""
    config = installation_of(app).config
    files = [config.instance / f"annotation.sqlite{end}" for end in ("", "-wal")]

    def is_held() -> bool:
        return any(file.exists() and b"zebra" in file.read_bytes() for file in files)

    with reading(engine_of(app), one_state=True) as session:
        assert len(session.scalars(select(Answer)).all()) > 2
        assert run(command(app, "people", "erase", code_of(app, worked[0]), "--yes")) == 0
        assert "files still hold it" in capsys.readouterr().out
        assert is_held()
    assert "zebra" not in everything(app)
    serving.prepare(config)
    assert not is_held()


@BOTH
def test_others_can_do_the_work_again(app: Flask, worked: tuple[Browser, Browser]) -> None:
    """Whoever segmented: the command stays, and what was made of the segmentation goes."""
    _, bob = worked
    before = counts(app)
    assert run(command(app, "people", "erase", subject_of(bob.person), "--yes")) == 0
    after = counts(app)
    tasks = sorted(rows_in(app, select(Answer.task)))
    assert tasks == ["describe"]
    assert row_in(app, select(Answer)).body["text"] == ADAS
    left = rows_in(app, select(Item.task).where(Item.attention.is_(False)))
    assert sorted(left) == ["describe"] * 3 + ["rate"] * 2 + ["segment"]
    assert row_in(app, select(func.count()).where(Slot.answered)) == 1
    assert after["person"] == before["person"]
    carol = Browser(app)
    segment(carol)
    ground(carol)
    check(carol)
    for _ in range(3):
        assert carol.lease("rate").status_code == 200
        carol.do("rate", {"rating": 2, "watched_s": 1.0})


@BOTH
def test_an_item_made_of_a_replaced_answer_goes_too(app: Flask) -> None:
    """Its subject tells no more whose it was."""
    ada, boss = Browser(app), Browser(app, "adjudicator")
    Browser(app).do("describe", described("Pick up the lamp now"))
    page = ada.take("segment")
    command_ = page["payload"]["command"]
    tree = to_json(parse_brackets("EVENT(r = Pick up, l = OBJ(f = lamp))", command=command_))
    ada.answer(page["item"], {"sdcs": tree})
    ground(Browser(app))
    better = to_json(parse_brackets("EVENT(r = Pick, l = OBJ(f = the lamp))", command=command_))
    assert boss.adjudicate(page["item"], {"sdcs": better}).status_code == 200
    subjects = rows_in(app, select(Item.subject).where(Item.task == "ground"))
    assert len(subjects) == 2
    assert any(subject.startswith("replaced ") for subject in subjects)
    assert run(command(app, "people", "erase", code_of(app, ada), "--yes")) == 0
    (left,) = rows_in(app, select(Item).where(Item.task == "ground"))
    assert left.payload["sdcs"] == better
    assert {a.person_id for a in rows_in(app, select(Answer))} >= {boss.person.id}
    assert run(command(app, "people", "erase", code_of(app, boss), "--yes")) == 0
    assert rows_in(app, select(Item).where(Item.task == "ground")) == []
    assert row_in(app, select(Item).where(Item.task == "segment"))


def participation(session: Any, study: Study, person: Person, assignment: str) -> Participation:
    made = Participation(
        study_id=study.id,
        person_id=person.id,
        provider="prolific",
        assignment=assignment,
        task="describe",
        items=1,
        begun_at=1.0,
        received_at=2.0,
        outcome={},
    )
    session.add(made)
    session.flush()
    return made


def pay(session: Any, study: Study, one: Participation) -> None:
    session.add(
        LedgerEntry(
            study_id=study.id,
            participation_id=one.id,
            provider="prolific",
            what="approve",
            key=one.assignment,
            assignment=one.assignment,
            amount="1.00",
            reason="",
            state="done",
            attempted_at=3.0,
            problem="",
        )
    )


@BOTH
def test_payments_stay_in_the_books(app: Flask, capsys: Any) -> None:
    """A worker is found by their id at the platform, with the key file's salt."""
    with app.app_context(), transaction(engine_of(app)) as session:
        study = find_study(session, "tests")
        person = find_or_add(session, "prolific", "5f1c0a")
        pay(session, study, participation(session, study, person, "paid"))
        participation(session, study, person, "unpaid")
    assert run(command(app, "people", "erase", "5f1c0a", "--yes")) == 2
    assert "--platform" in capsys.readouterr().err
    arguments = ["people", "erase", "5f1c0a", "--platform", "prolific"]
    assert run(command(app, *arguments, "--dry-run")) == 0
    assert "1 of these assignments were sent in" in capsys.readouterr().out
    assert run(command(app, *arguments, "--yes")) == 0
    assert rows_in(app, select(Participation.assignment)) == ["paid"]
    assert rows_in(app, select(LedgerEntry.assignment)) == ["paid"]
    assert run(command(app, *arguments, "--yes")) == 2


def test_somebody_with_a_login(app: Flask) -> None:
    with app.app_context(), transaction(engine_of(app)) as session:
        add_login(session, "maria", "admin", "correct horse", actor="tests")
    assert run(command(app, "people", "erase", "Maria", "--yes")) == 0
    with app.app_context(), reading(engine_of(app)) as session:
        assert matching(session, "maria", "correct horse") is None
        person = session.scalars(select(Person).where(Person.provider == "erased")).one()
        assert (person.role, person.login, person.password_hash) == ("worker", None, None)
    assert "maria" not in everything(app)


def test_nobody_or_too_many(app: Flask, capsys: Any) -> None:
    for who in ("nobody", "0123456789ab", "%", "_", "2222-2222-2222"):
        assert run(command(app, "people", "erase", who, "--yes")) == 2
        assert "there is no such person" in capsys.readouterr().err
    for given_ in ([], ["a", "--expired"], ["a", "--study", "b"], ["--platform", "b"]):
        assert run(command(app, "people", "erase", *given_)) == 2


_numbers = itertools.count()


@settings(
    max_examples=12,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(deeds=st.lists(st.tuples(st.integers(0, 2), st.integers(0, 4)), min_size=6, max_size=30))
def test_whatever_people_did(app: Flask, deeds: list[tuple[int, int]]) -> None:
    """What is left are the others' words, and as many free places as there should be."""
    people = [Browser(app) for _ in range(3)]
    words = [f"person{next(_numbers)}x" for _ in people]
    for who, what in deeds:
        person, task = people[who], ("describe", "segment", "ground", "check", "rate")[what]
        if person.lease(task).status_code != 200:
            continue
        if task == "describe":
            person.do("describe", described(f"Pick up the {words[who]}"))
        elif task == "rate":
            person.do("rate", {"rating": 3, "watched_s": 1.0})
        else:
            {"segment": segment, "ground": ground, "check": check}[task](person)
    config = installation_of(app).config
    done = erasure.erase_person(engine_of(app), config, people[0].person.id, now=time.time())
    assert words[0] not in everything(app)
    with reading(engine_of(app)) as session:
        mine = people[0].person.id
        for table in (Answer, Event, Slot):
            assert session.scalars(select(table).where(table.person_id == mine)).all() == []
        texts = [a.body["text"] for a in session.scalars(select(Answer)) if a.task == "describe"]
        kept = sum(what == 0 and who > 0 for who, what in deeds)
        assert len([t for t in texts if t.split()[-1] in words[1:]]) <= kept
        filled = select(func.count()).where(Slot.answered)
        counted = select(func.count()).where(Answer.surplus.is_(False))
        assert session.scalar(filled) == session.scalar(counted)
        gone = set(done.traces.items)
        assert not gone & set(session.scalars(select(Item.id)))
        made_of = {
            item.payload["command"]
            for item in session.scalars(select(Item))
            if item.payload.get("command") is not None
        }
        assert made_of <= set(session.scalars(select(Answer.id)))
    if engine_of(app).dialect.name == "sqlite":
        with engine_of(app).connect() as connection:
            assert connection.exec_driver_sql("PRAGMA foreign_key_check").all() == []
