"""Sessions of browsers: the person of a request, by the signed cookie and the database.

A cookie names a person and the number of their session. Raising the number in the person's
row ends all their sessions at once; each read of the person compares it in the same statement.
"""

from __future__ import annotations

import datetime
import time

import flask
from flask import Flask, Request
from flask.sessions import SecureCookieSession, SecureCookieSessionInterface, SessionMixin
from itsdangerous import BadSignature, URLSafeTimedSerializer
from sqlalchemy import bindparam, select
from sqlalchemy.orm import Session

from annotation_app.core.languages import gettext
from annotation_app.core.problems import TO_OPEN_AGAIN, TO_SIGN_IN, Refusal
from annotation_app.people.participants import RANKS, ROLE_NAMES
from annotation_app.store.models import Person, Role

PERSON, NUMBER, LOGIN = "person", "number", "login"
"""Keys of the cookie: the person, the number of the session, and whether the person has a login."""
FIRST = 1
"""The number of sessions that began before they were numbered."""
LONGEST = datetime.timedelta(days=60)
"""Lifetime of workers' cookies, without which their work is lost to them."""
REFRESH_S = 300.0
"""Interval between signatures of a cookie, so that work on one page doesn't seem idle."""
_KEPT = ("csrf_token", LOGIN, "_permanent")
"""Keys kept of an idle person's session: their forms prompt for a sign-in."""


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
    """Return the person's id by the browser's cookie, which can't be forged.

    It holds only together with :func:`current_number`.
    """
    person_id = flask.session.get(PERSON)
    return person_id if isinstance(person_id, str) else None


def current_number() -> int:
    """Return the number of the person's session that the browser has."""
    number = flask.session.get(NUMBER, FIRST)
    return number if isinstance(number, int) else 0


def is_signed_in(person: Person) -> bool:
    """Check that this request belongs to a person already."""
    return current_id() == person.id and current_number() == person.session_number


def had_login() -> bool:
    """Check that this browser was used with a login, without a sign-out since."""
    return LOGIN in flask.session


_PERSON = select(Person).where(
    Person.id == bindparam("who"), Person.session_number == bindparam("number")
)


def current_person(session: Session) -> Person | None:
    """Return the person of this request."""
    person_id = current_id()
    if person_id is None:
        return None
    return session.scalars(_PERSON, {"who": person_id, "number": current_number()}).first()


def required_person(session: Session, role: Role = "worker") -> Person:
    """Return the person of this request, who must have a role.

    Refused if nobody is known here, or they haven't the role, or have it no more. Workers who
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
    """Return the refusal for strangers: only what needs a login is a reason to sign in."""
    needs_login = role != "worker" or had_login()
    return Refusal(401, gettext(TO_SIGN_IN if needs_login else TO_OPEN_AGAIN))


class CookieSession(SecureCookieSession):
    """Contents of a cookie, and its age."""

    age_s: float = 0.0


class SessionCookies(SecureCookieSessionInterface):
    """Cookies that are valid from the last opened page, not from each request of its script.

    Signing one again takes a tenth of an answer's time. Somebody with a login may do nothing for
    `idle_s` seconds.
    """

    session_class = CookieSession

    def __init__(self, idle_s: float) -> None:
        self.idle_s = idle_s

    def open_session(self, app: Flask, request: Request) -> CookieSession | None:
        """Read the cookie. One that seems to come from the future holds: the clock was set back."""
        signer = self.get_signing_serializer(app)
        if signer is None:
            return None
        assert isinstance(signer, URLSafeTimedSerializer)  # noqa: S101 - it is Flask's
        value = request.cookies.get(self.get_cookie_name(app))
        if not value:
            return CookieSession()
        try:
            data, signed_at = signer.loads(value, return_timestamp=True)
        except BadSignature:
            return CookieSession()
        age_s = max(0.0, time.time() - signed_at.timestamp())
        if age_s > app.permanent_session_lifetime.total_seconds():
            return CookieSession()
        if LOGIN in data and age_s > self.idle_s:
            data = {name: data[name] for name in _KEPT if name in data}
        session = CookieSession(data)
        session.age_s = age_s
        return session

    def should_set_cookie(self, app: Flask, session: SessionMixin) -> bool:
        """Check that an answer brings a new cookie."""
        if not wants_json():
            return super().should_set_cookie(app, session)
        return session.modified or self._is_at_work(session)

    def _is_at_work(self, session: SessionMixin) -> bool:
        # A page that is left open asks for numbers all the time; only people change something.
        return (
            isinstance(session, CookieSession)
            and session.age_s > min(REFRESH_S, self.idle_s / 2)
            and LOGIN in session
            and PERSON in session
            and flask.request.method not in ("GET", "HEAD", "OPTIONS")
        )


def wants_json() -> bool:
    """Check that a request is a program's, not a person's."""
    return flask.request.path.startswith("/api/")
