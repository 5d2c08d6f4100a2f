"""Who gets what, and what becomes of answers that are early, late, doubled or lost."""

from __future__ import annotations

import uuid
from collections import Counter
from concurrent.futures import ThreadPoolExecutor

import pytest
from flask import Flask
from sqlalchemy import func, select, update
from sqlalchemy.exc import IntegrityError

from annotation_app.items.assignment import Lease, take
from annotation_app.items.submissions import submit
from annotation_app.store.database import reading, transaction
from annotation_app.store.installation import now
from annotation_app.store.models import Answer, Draft, Event, Item, Person, Slot, Study
from tests.annotation_app.browser import Browser, described, engine_of, execute, row_in, rows_in
from tests.annotation_app.rendered import VIDEOS

pytestmark = pytest.mark.parametrize("kind", ["sqlite", "postgresql"])


def expire(app: Flask) -> None:
    execute(app, update(Slot).where(Slot.person_id.is_not(None)).values(expires_at=now() - 1))


def finish(app: Flask, task: str, *, leave: int) -> None:
    """Answer all but some slots of a task."""
    open_ = select(Slot.id).join(Item).where(Item.task == task, Slot.answered.is_(False))
    while leave < len(rows_in(app, open_)):
        Browser(app).do(task, described())


def test_everybody_gets_each_video_once_and_quotas_are_kept(app: Flask) -> None:
    people = [Browser(app) for _ in range(2)]
    for person in people:
        seen = {person.take("describe")["payload"]["video"]}
        for _ in VIDEOS:
            seen.add(person.take("describe")["payload"]["video"])
            assert person.do("describe", described())["state"] == "accepted"
        assert len(seen) == len(VIDEOS)
        assert person.lease("describe").json["reason"] == "done"
    assert Browser(app).lease("describe").json["reason"] == "nothing to do"


def test_the_database_keeps_one_answer_by_person_task_and_video(app: Flask) -> None:
    person = Browser(app)
    person.do("describe", described())
    with reading(engine_of(app)) as session:
        answer = session.scalars(select(Answer)).one()
        other = session.scalars(select(Item).where(Item.id != answer.item_id)).first()
    assert other is not None
    columns = {c: getattr(answer, c) for c in ("person_id", "task", "subject", "body")}
    again = Answer(**columns, item_id=other.id, event_id=0, surplus=False, seconds=0, at=0)
    with transaction(engine_of(app)) as session:
        event = Event(
            uuid="x", item_id=other.id, person_id=person.person.id, name="submit", body={}, at=0.0
        )
        session.add(event)
        session.flush()
        again.event_id = event.id
        session.add(again)
        with pytest.raises(IntegrityError):
            session.flush()
        session.rollback()


def test_an_item_stays_somebodys_in_every_tab(app: Flask) -> None:
    person = Browser(app)
    first = person.take("describe")
    assert person.take("describe") == first
    one = person.answer(first["item"], described("Go there"))
    other = person.answer(first["item"], described("Go elsewhere"))
    assert (one.json["state"], other.json["state"]) == ("accepted", "repeated")
    assert rows_in(app, select(Answer.body["text"].as_string())) == ["Go there"]
    assert row_in(app, select(func.count()).select_from(Event)) == 2


def test_the_same_answer_sent_again_gets_the_same_receipt(app: Flask) -> None:
    person, event = Browser(app), str(uuid.uuid4())
    item = person.take("describe")["item"]
    replies = [person.answer(item, described(), event).json for _ in range(3)]
    assert [reply["state"] for reply in replies] == ["accepted"] * 3
    assert row_in(app, select(func.count()).select_from(Event)) == 1


def test_somebody_elses_uuid_is_of_no_account(app: Flask) -> None:
    one, other, event = Browser(app), Browser(app), str(uuid.uuid4())
    for person in (one, other):
        reply = person.answer(person.take("describe")["item"], described(), event)
        assert reply.json["state"] == "accepted"
    assert row_in(app, select(func.count()).select_from(Answer)) == 2


def test_an_expired_lease_frees_the_task(app: Flask) -> None:
    """Label Studio #4781: expired locks that don't free the task."""
    finish(app, "describe", leave=1)
    gone, other = Browser(app), Browser(app)
    item = gone.take("describe")["item"]
    assert other.lease("describe").json["reason"] == "all taken"
    expire(app)
    assert other.take("describe")["item"] == item


def test_a_late_answer_is_kept(app: Flask) -> None:
    finish(app, "describe", leave=1)
    late, quick = Browser(app), Browser(app)
    item = late.take("describe")["item"]
    expire(app)
    assert quick.take("describe")["item"] == item
    assert quick.do("describe", described())["state"] == "accepted"
    assert late.answer(item, described("Too late")).json["state"] == "surplus"
    kept = row_in(app, select(Answer).where(Answer.surplus))
    assert kept.body["text"] == "Too late"


def test_a_late_answer_counts_while_nobody_else_has_the_item(app: Flask) -> None:
    person = Browser(app)
    item = person.take("describe")["item"]
    expire(app)
    assert person.answer(item, described()).json["state"] == "accepted"


def test_a_late_answer_takes_a_free_slot(app: Flask) -> None:
    late, other = Browser(app), Browser(app)
    item = late.take("describe")["item"]
    expire(app)
    assert other.take("describe")["item"] == item
    assert late.answer(item, described()).json["state"] == "accepted"
    assert other.do("describe", described())["state"] == "accepted"


def test_a_draft_never_overwrites_an_answer(app: Flask) -> None:
    """Label Studio #1790: a draft that overwrites a submitted answer."""
    person = Browser(app)
    item = person.take("describe")["item"]
    assert person.draft(item, 1, {"text": "G"}).json == {"kept": True, "leased": True}
    person.answer(item, described("Go there"))
    assert person.draft(item, 2, {"text": "Go th"}).json["kept"] is False
    assert row_in(app, select(Answer)).body["text"] == "Go there"
    assert rows_in(app, select(Draft)) == []


def test_a_draft_goes_with_its_answer(app: Flask) -> None:
    """What somebody typed and took back isn't kept; other drafts are."""
    person, other = Browser(app), Browser(app)
    item = person.take("describe")["item"]
    for one in (person, other):
        one.take("describe")
        one.draft(item, 1, {"text": "My name is Ada."})
    event = str(uuid.uuid4())
    for _ in range(2):  # sent again it is the same answer
        assert person.answer(item, described(), event).json["state"] == "accepted"
    assert person.draft(item, 9, {"text": "late"}).json["kept"] is False
    assert [draft.person_id for draft in rows_in(app, select(Draft))] == [other.person.id]


def test_drafts_that_come_out_of_order(app: Flask) -> None:
    person = Browser(app)
    item = person.take("describe")["item"]
    assert person.draft(item, 5, {"text": "later"}).json["kept"]
    assert not person.draft(item, 4, {"text": "earlier"}).json["kept"]
    assert person.take("describe")["draft"] == {"revision": 5, "body": {"text": "later"}}


def test_a_draft_that_is_sent_again_is_there_already(app: Flask) -> None:
    """A page that is loaded again within a second sends what it sent when it was left."""
    person = Browser(app)
    item = person.take("describe")["item"]
    for _ in range(2):
        assert person.draft(item, 3, {"text": "Go"}).json["kept"]
    assert not person.draft(item, 3, {"text": "Stop"}).json["kept"]
    assert not person.draft(item, 2, {"text": "Go"}).json["kept"]
    person.answer(item, described())
    assert not person.draft(item, 3, {"text": "Go"}).json["kept"]


def test_a_draft_prolongs_the_lease(app: Flask) -> None:
    finish(app, "describe", leave=1)
    person = Browser(app)
    item = person.take("describe")["item"]
    expire(app)
    person.draft(item, 1, {})
    assert Browser(app).lease("describe").json["reason"] == "all taken"


def test_a_skipped_item_goes_to_others(app: Flask) -> None:
    finish(app, "describe", leave=1)
    person = Browser(app)
    item = person.take("describe")["item"]
    for _ in range(2):
        person.note(item, "skip", "the video doesn't play")
    assert person.lease("describe").json["reason"] == "done"
    assert Browser(app).take("describe")["item"] == item


def test_a_flag_is_kept(app: Flask) -> None:
    person = Browser(app)
    item = person.take("describe")["item"]
    person.note(item, "flag", "it is upside down")
    event = row_in(app, select(Event))
    assert (event.name, event.body) == ("flag", {"reason": "it is upside down"})


def test_nobody_answers_what_they_were_not_given(app: Flask) -> None:
    one, other = Browser(app), Browser(app)
    item = one.take("describe")["item"]
    assert other.answer(item, described()).status_code == 404
    assert other.answer("0" * 24, described()).status_code == 404
    assert other.client.get(f"/api/items/{item}").status_code == 404
    assert one.client.get(f"/api/items/{item}").json["item"] == item


def test_nobody_rates_their_own_command(app: Flask) -> None:
    author = Browser(app)
    author.do("describe", described("Go over there"))
    while author.lease("rate").status_code == 200:
        page = author.take("rate")
        assert page["payload"]["command"] != "Go over there"
        author.answer(page["item"], {"rating": 3, "watched_s": 1.0})


def test_attention_checks_are_mixed_in(app: Flask) -> None:
    Browser(app).do("describe", described("Go over there"))
    rater = Browser(app)
    commands = []
    for _ in range(4):
        page = rater.take("rate")
        assert "right" not in str(page)
        commands.append(page["payload"]["command"])
        rater.answer(page["item"], {"rating": 1, "watched_s": 1.0})
    assert commands.count("Wait here.") == 2


def test_why_there_is_no_item(app: Flask) -> None:
    newcomer = Browser(app, study=None)
    assert newcomer.lease("describe").json["reason"] == "no consent"
    blocked = Browser(app)
    with transaction(engine_of(app)) as session:
        session.get_one(Person, blocked.person.id).blocked_at = now()
    assert blocked.lease("describe").json["reason"] == "blocked"
    with transaction(engine_of(app)) as session:
        session.scalars(select(Study)).one().closed_at = now()
    assert Browser(app).lease("describe").json["reason"] == "closed"
    assert Browser(app).lease("describe", study="other").status_code == 404
    assert Browser(app).lease("sing").status_code == 404


@pytest.mark.parametrize("people", [24])
def test_two_people_never_get_the_same_slot(app: Flask, people: int) -> None:
    """Label Studio #795: two collaborators given the same task."""
    engine = engine_of(app)
    study = row_in(engine, select(Study))
    persons = [Browser(app).person for _ in range(people)]

    def work(person: Person) -> list[str]:
        done = []
        while True:
            with transaction(engine) as session:
                lease = take(session, study.id, "describe", person, now=now(), lease_s=60)
            if not isinstance(lease, Lease):
                return done
            with transaction(engine) as session:
                item = session.get_one(Item, lease.item_id)
                receipt = submit(
                    session, item, person.id, uuid=str(uuid.uuid4()), sent={}, body={}, now=now()
                )
            assert receipt.state == "accepted"
            done.append(item.subject)

    with ThreadPoolExecutor(8) as pool:
        done = list(pool.map(work, persons))
    subjects = [subject for own in done for subject in own]
    assert len(subjects) == 2 * len(VIDEOS)
    assert all(len(set(own)) == len(own) for own in done)
    assert {subjects.count(subject) for subject in subjects} == {2}


def test_one_person_in_many_tabs_at_once(app: Flask) -> None:
    person = Browser(app).person
    engine = engine_of(app)
    study = row_in(engine, select(Study))

    def tab(_: int) -> str:
        with transaction(engine) as session:
            lease = take(session, study.id, "describe", person, now=now(), lease_s=60)
            assert isinstance(lease, Lease)
            return lease.item_id

    with ThreadPoolExecutor(8) as pool:
        assert len(set(pool.map(tab, range(16)))) == 1


@pytest.mark.parametrize("same", [True, False])
def test_one_item_answered_many_times_at_once(app: Flask, same: bool) -> None:
    """A double click sends the same answer, two tabs send two; others' slots stay free."""
    browser, engine = Browser(app), engine_of(app)
    taken = browser.take("describe")["item"]
    with reading(engine) as session:
        item = session.get_one(Item, taken)
    event = str(uuid.uuid4())

    def send(_: int) -> str:
        sent = event if same else str(uuid.uuid4())
        with transaction(engine) as session:
            receipt = submit(
                session, item, browser.person.id, uuid=sent, sent={}, body={}, now=now()
            )
        return receipt.state

    with ThreadPoolExecutor(8) as pool:
        states = Counter(pool.map(send, range(16)))
    assert states == ({"accepted": 16} if same else {"accepted": 1, "repeated": 15})
    assert row_in(engine, select(func.count()).select_from(Event)) == (1 if same else 16)
    assert row_in(engine, select(func.count()).where(Slot.answered)) == 1
    answer = row_in(engine, select(Answer))
    assert answer.adopted
    assert 0 < answer.seconds < 60
