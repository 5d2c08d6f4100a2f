"""Retention: long after a study was closed, its answers stay without any link to people.

``retention_days`` in the study's file is the time. Afterwards people's profiles, drafts, and all
links from answers to people are erased: hashes of platforms' ids, codes, assignments.
Payments stay in the books, without any link to the answers they were for.
"""

from __future__ import annotations

import secrets
from collections.abc import Sequence, Set
from dataclasses import dataclass

from sqlalchemy import Engine, delete, select, union
from sqlalchemy.orm import Session

from annotation_app.core.random_ids import new_id
from annotation_app.privacy.erasure import ERASED, is_booked, unlink
from annotation_app.store.audit import COMMAND_LINE, note
from annotation_app.store.compaction import ask, compact_if_asked
from annotation_app.store.database import lock_set_up, transaction
from annotation_app.store.models import Draft, Handout, Item, Participation, Person, Study
from annotation_app.studies.study_file import restored

DAY_S = 86_400.0


@dataclass(slots=True)
class Expired:
    """Result of a study's expiry, or its preview.

    `people` lost all that identifies them, `profiles` their contents, and `payments_unlinked` the
    link to the answers.
    """

    study: str
    people: int = 0
    profiles: int = 0
    drafts: int = 0
    assignments: int = 0
    payments_unlinked: int = 0


def expire(
    engine: Engine, *, now: float, study: str | None = None, dry_run: bool = False
) -> list[Expired]:
    """Expire what is due by now in all studies, or in one. A second run does nothing.

    Results are returned for the studies in which something was due.
    """
    with transaction(engine) as session:
        lock_set_up(session.connection())
        studies = session.scalars(select(Study).order_by(Study.name)).all()
        over = {one.id for one in studies if _is_over(one, now)}
        due = [one for one in studies if one.id in over and study in (None, one.name)]
        found = [_expire(session, one, over) for one in due]
        done = [one for one in found if one != Expired(one.study)]
        if dry_run:
            session.rollback()
            return done
        for of_study in done:
            counts = {"people": of_study.people, "drafts": of_study.drafts}
            note(session, COMMAND_LINE, "unlinked from people", of_study.study, **counts)
        if done:
            ask(session)
    compact_if_asked(engine)
    return done


def _is_over(study: Study, now: float) -> bool:
    days = restored(study.config).retention_days
    return days is not None and study.closed_at is not None and study.closed_at + days * DAY_S < now


def _expire(session: Session, study: Study, over: Set[str]) -> Expired:
    found = Expired(study.name)
    items = select(Item.id).where(Item.study_id == study.id)
    drafts = delete(Draft).where(Draft.item_id.in_(items)).returning(Draft.item_id)
    found.drafts = len(session.execute(drafts).all())
    _unlink_payments(session, study, found)
    for person in _people(session, study):
        told = person.profile.get("answers", {})
        if study.id in told:
            rest = {key: value for key, value in told.items() if key != study.id}
            person.profile = {**person.profile, "answers": rest}
            found.profiles += bool(told[study.id])
        is_staff = person.login is not None
        if person.provider != ERASED and not is_staff and _studies_of(session, person) <= over:
            unlink(person)
            found.people += 1
    session.flush()
    return found


def _unlink_payments(session: Session, study: Study, found: Expired) -> None:
    rows = session.execute(
        select(Participation, Person)
        .join(Person, Person.id == Participation.person_id)
        .where(Participation.study_id == study.id, Person.provider != ERASED)
    ).all()
    for participation, person in rows:
        if not is_booked(session, participation):
            session.delete(participation)
            found.assignments += 1
            continue
        nobody = Person(
            id=new_id(),
            role="worker",
            provider=ERASED,
            external_hash=secrets.token_hex(32),
            profile={},
            created_at=person.created_at,
        )
        session.add(nobody)
        session.flush()
        participation.person_id = nobody.id
        found.payments_unlinked += 1
    session.flush()


def _people(session: Session, study: Study) -> Sequence[Person]:
    """Return the people with items in a study, or with an assignment or consent for it."""
    came = union(
        select(Handout.person_id)
        .join(Item, Item.id == Handout.item_id)
        .where(Item.study_id == study.id),
        select(Person.id).where(Person.profile["consent"][study.id].as_string().is_not(None)),
    )
    return session.scalars(select(Person).where(Person.id.in_(came))).all()


def _studies_of(session: Session, person: Person) -> set[str]:
    """Return the ids of studies in which a person takes or has taken part."""
    given = (
        select(Item.study_id)
        .join(Handout, Handout.item_id == Item.id)
        .where(Handout.person_id == person.id)
    )
    came = select(Participation.study_id).where(Participation.person_id == person.id)
    return {*session.scalars(union(given, came)), *person.profile.get("consent", {})}
