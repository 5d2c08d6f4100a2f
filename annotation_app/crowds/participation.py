"""Assignments of people: their requirements, and the work received."""

from __future__ import annotations

import hashlib
import hmac
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from itsdangerous import BadSignature
from sqlalchemy import select
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from annotation_app.core.languages import gettext
from annotation_app.core.problems import Refusal
from annotation_app.items.assignment import lock_person
from annotation_app.people.participants import link_signer
from annotation_app.store.models import Answer, Item, Participation, Person, Study, TaskName
from annotation_app.tasks.task_registry import find_task

CODE_CHARACTERS = 10


@dataclass(frozen=True, slots=True)
class Offer:
    """Offer of an address: a number of items of a study's task."""

    study_id: str
    task: TaskName
    items: int


def sign_offer(secret_key: bytes, offer: Offer) -> str:
    """Return the part of an address that names an offer, and that nobody else can make."""
    signer = link_signer(secret_key, "offer")
    return str(signer.dumps([offer.study_id, offer.task, offer.items]))


def read_offer(secret_key: bytes, token: str) -> Offer:
    """Return the offer of an address; refused if it wasn't made here."""
    try:
        value: Any = link_signer(secret_key, "offer").loads(token[:1000])
    except BadSignature:
        raise Refusal(
            404, gettext("This link is not complete. Open it from the platform again.")
        ) from None
    study_id, task, items = value
    if find_task(task) is None:
        raise Refusal(404, gettext("The task of this link is not here any more."))
    return Offer(str(study_id), task, int(items))


def completion_code(secret_key: bytes, offer: Offer) -> str:
    """Return a platform's proof that an offer's work was done.

    It follows from the offer, so that the platform can have it before anybody has come.
    """
    message = f"code\0{offer.study_id}\0{offer.task}\0{offer.items}".encode()
    digest = hmac.new(secret_key, message, hashlib.sha256).hexdigest()
    return digest[:CODE_CHARACTERS].upper()


def begin(
    session: Session,
    offer: Offer,
    person: Person,
    *,
    provider: str,
    assignment: str,
    code: str,
    submit_to: str,
    now: float,
) -> Participation:
    """Return the person's assignment, kept since its first opening; refused if it is another's."""
    lock_person(session, person.id)
    found = session.scalars(
        select(Participation).where(
            Participation.provider == provider, Participation.assignment == assignment
        )
    ).first()
    if found is not None:
        if found.person_id != person.id:
            raise Refusal(403, gettext("This assignment is somebody else's. Open your own."))
        return found
    found = Participation(
        study_id=offer.study_id,
        person_id=person.id,
        provider=provider,
        assignment=assignment,
        task=offer.task,
        items=offer.items,
        code=code,
        begun_at=now,
        outcome={"submit_to": submit_to} if submit_to else {},
    )
    session.add(found)
    try:
        session.flush()
    except IntegrityError:  # two people have come with it at the same time
        raise Refusal(409, gettext("This assignment is open elsewhere. Open it again.")) from None
    return found


def credited(
    participations: Sequence[Participation], answered_at: Iterable[float]
) -> dict[int, int]:
    """Count somebody's answers for each of their assignments, by the assignments' ids.

    An answer counts for the assignment that was begun last and isn't full. An answer is
    never paid twice, and none goes to an assignment that was given up before.
    """
    counts = {p.id: 0 for p in participations}
    latest_first = sorted(participations, key=lambda p: (p.begun_at, p.id), reverse=True)
    for at in sorted(answered_at):
        for one in latest_first:
            is_open = one.received_at is None or at <= one.received_at
            if one.begun_at <= at and is_open and counts[one.id] < one.items:
                counts[one.id] += 1
                break
    return counts


def done(session: Session, study: Study, provider: str | None = None) -> Mapping[int, int]:
    """Count the items received for each of a study's assignments, by their ids."""
    wanted = select(Participation).where(Participation.study_id == study.id)
    if provider is not None:
        wanted = wanted.where(Participation.provider == provider)
    groups: dict[tuple[str, TaskName], list[Participation]] = {}
    for one in session.scalars(wanted):
        groups.setdefault((one.person_id, one.task), []).append(one)
    answers: dict[tuple[str, TaskName], list[float]] = {}
    rows = session.execute(
        select(Answer.person_id, Answer.task, Answer.at)
        .join(Item, Item.id == Answer.item_id)
        .where(Item.study_id == study.id)
    )
    for person_id, task, at in rows:
        answers.setdefault((person_id, task), []).append(at)
    counts: dict[int, int] = {}
    for key, group in groups.items():
        counts |= credited(group, answers.get(key, ()))
    return counts


def done_of(session: Session, participation: Participation) -> int:
    """Count the items received for an assignment."""
    mine = session.scalars(
        select(Participation).where(
            Participation.study_id == participation.study_id,
            Participation.person_id == participation.person_id,
            Participation.task == participation.task,
        )
    ).all()
    answered_at = session.scalars(
        select(Answer.at)
        .join(Item, Item.id == Answer.item_id)
        .where(
            Item.study_id == participation.study_id,
            Answer.task == participation.task,
            Answer.person_id == participation.person_id,
        )
    )
    return credited(mine, answered_at)[participation.id]


def receive(participation: Participation, *, done: int, nothing_left: bool, now: float) -> bool:
    """Note that an assignment is done, if it is; whether it is.

    It is done too if there is nothing left for the person, who can't help that.
    """
    if participation.received_at is None and (done >= participation.items or nothing_left):
        participation.received_at = now
        if done < participation.items:
            participation.outcome = {**participation.outcome, "nothing_left": True}
    return participation.received_at is not None
