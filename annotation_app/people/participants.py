"""Participants: roles, invitations, consent. Ids from elsewhere are kept as hashes."""

from __future__ import annotations

import hashlib
import hmac
import secrets
from typing import Any, Literal

from itsdangerous import BadSignature, URLSafeSerializer
from sqlalchemy import select
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from annotation_app.core.languages import N_, gettext
from annotation_app.core.problems import Refusal
from annotation_app.core.random_ids import new_code, new_id
from annotation_app.store.audit import SUBJECT_CHARACTERS
from annotation_app.store.installation import installation, now
from annotation_app.store.models import Participation, Person, Record, Role

OPEN = "open"
INVITED = "invited"
LOGIN = "login"

RANKS: dict[Role, int] = {"worker": 0, "annotator": 1, "adjudicator": 2, "admin": 3}
ROLE_NAMES: dict[Role, str] = {
    "worker": N_("worker"),
    "annotator": N_("annotator"),
    "adjudicator": N_("adjudicator"),
    "admin": N_("admin"),
}
"""Roles, each with the rights of those before."""


def hashed(salt: bytes, provider: str, external: str) -> str:
    """Return the hash of somebody's id at a provider, which is kept instead of it."""
    return hmac.new(salt, f"{provider}\0{external}".encode(), hashlib.sha256).hexdigest()


def find_or_add(session: Session, provider: str, external: str) -> Person:
    """Return the person with an id at a provider."""
    digest = hashed(installation().salt, provider, external)
    known = select(Person).where(Person.provider == provider, Person.external_hash == digest)
    found = session.scalars(known).first()
    if found is not None:
        return found
    try:
        with session.begin_nested():
            return add_person(session, provider, digest)
    except IntegrityError:  # the same person has come by another request at the same time
        return session.scalars(known).one()


def add_person(
    session: Session,
    provider: str,
    external_hash: str,
    role: Role = "worker",
    *,
    login: str | None = None,
    password_hash: str | None = None,
) -> Person:
    """Add a person."""
    person = Person(
        id=new_id(),
        role=role,
        provider=provider,
        external_hash=external_hash,
        login=login,
        password_hash=password_hash,
        profile={},
        created_at=now(),
        code=new_code(),
    )
    session.add(person)
    session.flush()
    return person


def add_anonymous(session: Session) -> Person:
    """Add a person who came by an open link."""
    return find_or_add(session, OPEN, secrets.token_hex(16))


# Invitations


def invitation(secret_key: bytes, study_id: str, name: str) -> str:
    """Return the token of a link that invites a person.

    The name distinguishes people; it can't be read in the token, nor is it kept.
    """
    digest = hashed(secret_key, INVITED, name)
    return str(link_signer(secret_key, "invitation").dumps([study_id, digest]))


def read_invitation(token: str) -> tuple[str, str]:
    """Return the study's id and the hash of the invited person; refused if not made here."""
    try:
        signer = link_signer(installation().config.secret_key, "invitation")
        value: Any = signer.loads(token[:1000])
    except BadSignature:
        raise Refusal(404, gettext("This link is not complete. Copy all of it.")) from None
    return str(value[0]), str(value[1])


def accept_invitation(session: Session, token: str) -> tuple[str, Person]:
    """Return the study's id and the invited person, who is added if new."""
    study_id, digest = read_invitation(token)
    return study_id, find_or_add(session, INVITED, f"{study_id} {digest}")


def link_signer(secret_key: bytes, what: str) -> URLSafeSerializer:
    """Return a signer of links of a kind, which nobody else can make."""
    return URLSafeSerializer(secret_key, salt=what, signer_kwargs={"digest_method": hashlib.sha256})


# What people have said of themselves


def has_consented(person: Person, study_id: str) -> bool:
    """Check that somebody has agreed to take part in a study."""
    return study_id in person.profile.get("consent", {})


def keep_consent(person: Person, study_id: str, answers: Record) -> None:
    """Keep that somebody agrees to take part, and what they say of themselves."""
    profile = dict(person.profile)
    profile["consent"] = {**profile.get("consent", {}), study_id: now()}
    profile["answers"] = {**profile.get("answers", {}), study_id: answers}
    person.profile = profile


def has_practised(person: Person, task: str) -> bool:
    """Check that somebody has done a task's practice example."""
    return task in person.profile.get("practice", [])


def keep_practice(person: Person, task: str) -> None:
    """Keep that somebody has done a task's practice example."""
    if not has_practised(person, task):
        person.profile = {**person.profile, "practice": [*person.profile.get("practice", []), task]}


def subject_of(person: Person) -> str:
    """Return the name of a person in exports: a part of a salted hash."""
    return person.external_hash[:SUBJECT_CHARACTERS]


def platform_knowledge(session: Session, study_id: str) -> dict[str, Literal["known", "unknown"]]:
    """Return whether the platform knows the people who came from it, by their ids.

    A person named in any of its assignments is known. Nothing is known of others before platform
    and database were compared, and their assignments are over.
    """
    came = select(Participation.person_id).where(Participation.study_id == study_id)
    rows = session.execute(
        select(Participation.person_id, Participation.standing)
        .where(Participation.person_id.in_(came), Participation.standing.is_not(None))
        .order_by(Participation.standing == "unknown")
    )
    found: dict[str, Literal["known", "unknown"]] = {}
    for person_id, standing in rows:
        found.setdefault(person_id, "unknown" if standing == "unknown" else "known")
    return found
