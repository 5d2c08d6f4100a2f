"""Requesting people and programs: a person with a role, or a program with a token.

A request with ``Authorization: Bearer`` is a program's, even if it has cookies. It may only read:
changes need a person.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import ParamSpec, TypeAlias

import flask
from flask.typing import ResponseReturnValue as Reply
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import Session

from annotation_app.core.languages import N_, gettext
from annotation_app.core.problems import Refusal
from annotation_app.people import api_tokens
from annotation_app.people.browser_sessions import current_person, required_person
from annotation_app.store.audit import name_of
from annotation_app.store.database import OnlyReadError, reading, transaction
from annotation_app.store.installation import installation
from annotation_app.store.models import Person, Role
from annotation_app.web.limits import bearer, count_now
from g3.errors import CorpusError

P = ParamSpec("P")
Asked: TypeAlias = Iterator[tuple[Session, Person]]
WRONG_TOKENS = "60/minute"
"""By address: guessing is hopeless anyway, and isn't to be for nothing."""


@contextmanager
def seen_by(role: Role, *, one_state: bool = False) -> Asked:
    """Read the database for whose request this is, who must have a role or is refused."""
    with reading(installation().engine, one_state=one_state) as session:
        yield session, required_person(session, role)


@contextmanager
def changed_by(role: Role) -> Asked:
    """Change the database for whose request this is, in the same way."""
    with transaction(installation().engine) as session:
        yield session, required_person(session, role)


def sign_in_page() -> Reply:
    """Redirect to the page to sign in, and from there back here."""
    return flask.redirect(flask.url_for("account.login", next=flask.request.path))


def cannot_be_done(error: CorpusError) -> Reply:
    """Return a reply with the fault of a file that can't be read or written."""
    return refused(Refusal(422, f"This can't be done: {error}."))


def refused(refusal: Refusal) -> Reply:
    """Redirect to sign in and back, or render the reason for the refusal."""
    if refusal.status == 401 and flask.request.method == "GET":
        return sign_in_page()
    return error_page(refusal.status, refusal.message, signs_in=refusal.status in (401, 403))


_ADVICE = {
    403: N_("If you think that it is for you, ask the people who run the study."),
    404: N_("The address may be mistyped, or what was here has been removed."),
}


def error_page(status: int, message: str, advice: str = "", *, signs_in: bool = False) -> Reply:
    """Render an error, in the frame of all pages, with the next step.

    `signs_in` offers to sign in to people who haven't; people of open studies need no login.
    """
    try:
        with reading(installation().engine) as session:
            person = current_person(session)
    except (SQLAlchemyError, OSError):
        person = None  # it may be the database that fails
    page = flask.render_template(
        "error.html",
        status=status,
        message=message,
        advice=advice or (gettext(_ADVICE[status]) if status in _ADVICE else ""),
        person=person,
        to_sign_in=signs_in and not (person and person.login),
    )
    return page, status


def refused_on(
    page: Callable[..., str], role: Role = "admin"
) -> Callable[[Callable[P, Reply]], Callable[P, Reply]]:
    """Show somebody whose request is refused the page that it came from, with the reason why.

    The page takes the database, the person, what the address names, and ``problem``.
    """

    def decorate(view: Callable[P, Reply]) -> Callable[P, Reply]:
        @functools.wraps(view)
        def shown(*args: P.args, **named: P.kwargs) -> Reply:
            try:
                return view(*args, **named)
            except Refusal as refusal:
                if refusal.status in (401, 403):
                    raise
                with seen_by(role) as (session, person):
                    return page(session, person, **named, problem=refusal.message), refusal.status

        return shown

    return decorate


def required_reader(session: Session, role: Role) -> str:
    """Return the reader's name in the audit trail. A program reads as adjudicators do.

    It is refused if nobody is known, a person hasn't the role, or the token isn't one any more.
    """
    token = bearer()
    if token is None:
        return name_of(required_person(session, role))
    found = api_tokens.find_token(session, token)
    if found is None or role == "admin":
        count_now(WRONG_TOKENS, "wrong token", str(flask.request.remote_addr))
        raise Refusal(401, "This token isn't one, was revoked, or has run out.")
    if api_tokens.is_newly_used(found):
        try:
            with transaction(installation().engine) as writing:
                api_tokens.note_use(writing, found)
        except (SQLAlchemyError, OnlyReadError, OSError):
            pass  # who can't be noted may read all the same
    return api_tokens.actor_of(found)
