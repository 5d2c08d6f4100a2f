"""Whose request this is: what the browser's cookie says, and the database still confirms.

A cookie names a person and the number of their session. Raising the number in the person's
row ends all their sessions at once; whoever reads the person compares it in the same statement.
"""

from __future__ import annotations

import flask
from sqlalchemy import bindparam, select
from sqlalchemy.orm import Session

from annotation_app.core.languages import gettext
from annotation_app.core.problems import TO_OPEN_AGAIN, TO_SIGN_IN, Refusal
from annotation_app.people.participants import RANKS, ROLE_NAMES
from annotation_app.store.models import Person, Role

PERSON, NUMBER, LOGIN = "person", "number", "login"
"""What the cookie holds: who, which of their sessions, and whether they have a login."""
FIRST = 1
"""The number of sessions that began before they were numbered."""


def sign_in(person: Person) -> None:
    """Make the rest of the browser's requests the person's."""
    flask.session.clear()
    flask.session[PERSON] = person.id
    flask.session[NUMBER] = person.session_number
    if person.login is not None:
        flask.session[LOGIN] = True
    flask.session.permanent = True


def sign_out() -> None:
    """Forget who the browser's person is."""
    flask.session.clear()


def end_sessions(session: Session, person: Person) -> None:
    """Let no cookie that a person's browsers hold sign them in any more."""
    person.session_number = Person.session_number + 1
    session.flush()
    session.refresh(person, ["session_number"])


def current_id() -> str | None:
    """What the browser says whose request this is; it can't make it up.

    It holds only together with :func:`current_number`.
    """
    person_id = flask.session.get(PERSON)
    return person_id if isinstance(person_id, str) else None


def current_number() -> int:
    """Which of the person's sessions the browser has."""
    number = flask.session.get(NUMBER, FIRST)
    return number if isinstance(number, int) else 0


def is_signed_in(person: Person) -> bool:
    """Whether this request is a person's already."""
    return current_id() == person.id and current_number() == person.session_number


def had_login() -> bool:
    """Whether somebody with a login has used this browser, and hasn't signed out in it."""
    return LOGIN in flask.session


_PERSON = select(Person).where(
    Person.id == bindparam("who"), Person.session_number == bindparam("number")
)


def current_person(session: Session) -> Person | None:
    """Whose request this is."""
    person_id = current_id()
    if person_id is None:
        return None
    return session.scalars(_PERSON, {"who": person_id, "number": current_number()}).first()


def required_person(session: Session, role: Role = "worker") -> Person:
    """Whose request this is, who must have a role.

    Raises
    ------
    Refusal
        If nobody is known here, or they haven't the role, or have it no more. Workers who
        are blocked may still send what they have.
    """
    person = current_person(session)
    if person is None:
        raise unknown(role)
    if RANKS[person.role] < RANKS[role]:
        raise Refusal(
            403,
            gettext("This is for people with the role %(role)s.", role=gettext(ROLE_NAMES[role])),
        )
    if role != "worker" and person.blocked_at is not None:
        raise Refusal(
            403, gettext("Your login has been blocked. Ask the people who run the study.")
        )
    return person


def unknown(role: Role = "worker") -> Refusal:
    """What strangers get: only what needs a login is a reason to sign in."""
    needs_login = role != "worker" or had_login()
    return Refusal(401, gettext(TO_SIGN_IN if needs_login else TO_OPEN_AGAIN))
