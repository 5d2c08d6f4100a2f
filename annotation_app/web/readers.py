"""Who reads: a person with a role, or a program with a token.

A request with ``Authorization: Bearer`` is a program's, whatever cookies come with it. It may
read, and nothing else: what changes something asks for a person.
"""

from __future__ import annotations

import flask
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import Session

from annotation_app.core.problems import Refusal
from annotation_app.people import api_tokens
from annotation_app.people.browser_sessions import required_person
from annotation_app.store.audit import name_of
from annotation_app.store.database import OnlyReadError, transaction
from annotation_app.store.installation import installation
from annotation_app.store.models import Role
from annotation_app.web.limits import bearer, count_now

WRONG_TOKENS = "60/minute"
"""By address: guessing is hopeless anyway, and isn't to be for nothing."""


def required_reader(session: Session, role: Role) -> str:
    """Who reads, as the audit trail calls them. A program reads what adjudicators may.

    Raises
    ------
    Refusal
        If nobody is known, a person hasn't the role, or the token isn't one any more.
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
