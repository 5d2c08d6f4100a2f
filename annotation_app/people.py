"""People: signing in, roles, invitations, consent. Ids from elsewhere are kept as hashes."""

from __future__ import annotations

import hashlib
import hmac
import secrets
from typing import Any

import flask
from itsdangerous import BadSignature, URLSafeSerializer
from sqlalchemy import bindparam, delete, select
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session
from werkzeug.security import check_password_hash, generate_password_hash

from annotation_app.database import lock_set_up
from annotation_app.installation import installation, now
from annotation_app.models import Person, Record, Role, Secret
from annotation_app.person_codes import new_code
from annotation_app.problems import TO_SIGN_IN, Refusal

ADMIN_TOKEN = "admin-token"  # noqa: S105 - the name of a secret, not one
SHORTEST_PASSWORD, LONGEST_PASSWORD = 10, 200
OPEN = "open"
INVITED = "invited"
LOGIN = "login"

_METHOD = "scrypt:32768:8:1"
_NOBODY = f"{_METHOD}${'0' * 16}${'0' * 128}"
"""Checked where there is no such login, so that time doesn't tell which logins there are."""

RANKS: dict[Role, int] = {"worker": 0, "annotator": 1, "adjudicator": 2, "admin": 3}
"""Who may do what others may: each what those before may."""


def new_id() -> str:
    """An id that can't be guessed."""
    return secrets.token_hex(12)


def hashed(salt: bytes, provider: str, external: str) -> str:
    """What is kept of somebody's id at a provider."""
    return hmac.new(salt, f"{provider}\0{external}".encode(), hashlib.sha256).hexdigest()


def find_or_add(session: Session, provider: str, external: str, role: Role = "worker") -> Person:
    """The person with an id at a provider."""
    digest = hashed(installation().salt, provider, external)
    known = select(Person).where(Person.provider == provider, Person.external_hash == digest)
    found = session.scalars(known).first()
    if found is not None:
        return found
    try:
        with session.begin_nested():
            return add_person(session, provider, digest, role)
    except IntegrityError:  # the same person has come by another request at the same time
        return session.scalars(known).one()


def add_person(
    session: Session,
    provider: str,
    external_hash: str,
    role: Role = "worker",
    *,
    login: str | None = None,
    password: str | None = None,
) -> Person:
    """A new person."""
    person = Person(
        id=new_id(),
        role=role,
        provider=provider,
        external_hash=external_hash,
        login=login,
        password_hash=None if password is None else _password_hash(password),
        profile={},
        created_at=now(),
        code=new_code(),
    )
    session.add(person)
    session.flush()
    return person


def add_anonymous(session: Session) -> Person:
    """A new person who came by an open link."""
    return find_or_add(session, OPEN, secrets.token_hex(16))


# Sign-in


def sign_in(person: Person) -> None:
    """Make the rest of the browser's requests the person's."""
    flask.session.clear()
    flask.session["person"] = person.id
    flask.session.permanent = True


def sign_out() -> None:
    """Forget who the browser's person is."""
    flask.session.clear()


def current_id() -> str | None:
    """What the browser says whose request this is; it can't make it up."""
    person_id = flask.session.get("person")
    return person_id if isinstance(person_id, str) else None


_PERSON = select(Person).where(Person.id == bindparam("who"))


def current_person(session: Session) -> Person | None:
    """Whose request this is."""
    person_id = current_id()
    return None if person_id is None else session.scalars(_PERSON, {"who": person_id}).first()


def required_person(session: Session, role: Role = "worker") -> Person:
    """Whose request this is, who must have a role.

    Raises
    ------
    Refusal
        If they aren't signed in, haven't the role, or have it no more. Workers who are
        blocked may still send what they have.
    """
    person = current_person(session)
    if person is None:
        raise Refusal(401, TO_SIGN_IN)
    if RANKS[person.role] < RANKS[role]:
        raise Refusal(403, f"This is for people with the role {role}.")
    if role != "worker" and person.blocked_at is not None:
        raise Refusal(403, "Your login has been blocked. Ask the people who run the study.")
    return person


def add_login(session: Session, login: str, password: str, role: Role) -> Person:
    """Somebody who signs in with a password.

    Raises
    ------
    Refusal
        If the login is taken or the password too short.
    """
    name = login.strip().casefold()
    if not 1 <= len(name) <= 100 or not name.isprintable():
        raise Refusal(422, "A login has 1 to 100 characters.")
    check_password(password)
    if session.scalar(select(Person.id).where(Person.login == name)) is not None:
        raise Refusal(422, "This login is taken. Choose another one.")
    digest = hashed(installation().salt, LOGIN, name)
    return add_person(session, LOGIN, digest, role, login=name, password=password)


def check_password(password: str) -> None:
    """Refuse passwords that are too short or too long."""
    if not SHORTEST_PASSWORD <= len(password) <= LONGEST_PASSWORD:
        raise Refusal(422, f"A password has {SHORTEST_PASSWORD} to {LONGEST_PASSWORD} characters.")


def find_login(session: Session, login: str, password: str) -> Person | None:
    """Who has this login and this password."""
    name = login.strip().casefold()
    person = session.scalars(select(Person).where(Person.login == name)).first()
    known = person.password_hash if person is not None and person.password_hash else _NOBODY
    matches = check_password_hash(known, password[:LONGEST_PASSWORD])
    return person if matches and person is not None and person.blocked_at is None else None


def _password_hash(password: str) -> str:
    return generate_password_hash(password, method=_METHOD)


# Invitations


def invitation(secret_key: bytes, study_id: str, name: str) -> str:
    """The token of a link that makes whoever opens it the invited person.

    Parameters
    ----------
    name
        Tells people apart; not readable in the token nor kept.
    """
    digest = hashed(secret_key, INVITED, name)
    return str(_invitations(secret_key).dumps([study_id, digest]))


def read_invitation(token: str) -> tuple[str, str]:
    """The study's id and the hash of the person that a link invites.

    Raises
    ------
    Refusal
        If nobody here has made it.
    """
    try:
        value: Any = _invitations(installation().config.secret_key).loads(token[:1000])
    except BadSignature:
        raise Refusal(404, "This link is not complete. Copy all of it.") from None
    return str(value[0]), str(value[1])


def accept_invitation(session: Session, token: str) -> tuple[str, Person]:
    """The study's id and the person that a link invites, who is added if new."""
    study_id, digest = read_invitation(token)
    return study_id, find_or_add(session, INVITED, f"{study_id} {digest}")


def _invitations(secret_key: bytes) -> URLSafeSerializer:
    return URLSafeSerializer(
        secret_key, salt="invitation", signer_kwargs={"digest_method": hashlib.sha256}
    )


# The first admin


def new_admin_token(session: Session) -> str | None:
    """A token with which the first admin can be made, once; None if there is an admin.

    An earlier token is of no use any more.
    """
    lock_set_up(session.connection())
    if session.scalar(select(Person.id).where(Person.role == "admin").limit(1)) is not None:
        return None
    token = secrets.token_urlsafe(24)
    session.merge(Secret(name=ADMIN_TOKEN, value=hashlib.sha256(token.encode()).digest()))
    return token


def use_admin_token(session: Session, token: str, login: str, password: str) -> Person:
    """Make the first admin. The token is used up.

    Raises
    ------
    Refusal
        If it isn't the token, or the login or the password can't be one.
    """
    kept = session.get(Secret, ADMIN_TOKEN, with_for_update=True)
    digest = hashlib.sha256(token.encode()).digest()
    if kept is None or not hmac.compare_digest(kept.value, digest):
        raise Refusal(
            404, "This link has been used or is an old one. Start the app again for a new one."
        )
    person = add_login(session, login, password, "admin")
    session.execute(delete(Secret).where(Secret.name == ADMIN_TOKEN))
    return person


# What people have told of themselves


def has_consented(person: Person, study_id: str) -> bool:
    """Whether somebody has agreed to take part in a study."""
    return study_id in person.profile.get("consent", {})


def keep_consent(person: Person, study_id: str, answers: Record) -> None:
    """Keep that somebody agrees to take part, and what they tell of themselves."""
    profile = dict(person.profile)
    profile["consent"] = {**profile.get("consent", {}), study_id: now()}
    profile["answers"] = {**profile.get("answers", {}), study_id: answers}
    person.profile = profile


def has_practised(person: Person, task: str) -> bool:
    """Whether somebody has done a task's practice example."""
    return task in person.profile.get("practice", [])


def keep_practice(person: Person, task: str) -> None:
    """Keep that somebody has done a task's practice example."""
    if not has_practised(person, task):
        person.profile = {**person.profile, "practice": [*person.profile.get("practice", []), task]}
