"""Sessions in signed cookies: how long they hold, and when they are signed anew."""

from __future__ import annotations

import datetime
import time

import flask
from flask import Flask, Request
from flask.sessions import SecureCookieSession, SecureCookieSessionInterface, SessionMixin
from itsdangerous import BadSignature, URLSafeTimedSerializer

from annotation_app.people.browser_sessions import LOGIN, PERSON

LONGEST = datetime.timedelta(days=60)
"""For workers: without their cookie nobody finds what they have begun."""
REFRESH_S = 300.0
"""Somebody who works on one page doesn't seem idle: their cookie is signed anew so often."""
_KEPT = ("csrf_token", LOGIN, "_permanent")
"""What stays of the session of somebody who was idle: their forms ask them to sign in."""


class CookieSession(SecureCookieSession):
    """What a cookie says, and how old it is."""

    age_s: float = 0.0


class SessionCookies(SecureCookieSessionInterface):
    """Cookies that hold from the last page that was opened, not from each request of its script.

    To sign one anew takes a tenth of an answer's time.

    Parameters
    ----------
    idle_s
        How long somebody with a login may do nothing.
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
        """Whether an answer brings a new cookie."""
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
    """Whether a request is a program's, not a person's."""
    return flask.request.path.startswith("/api/")
