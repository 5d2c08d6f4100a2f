"""Tokens by which programs read a study's numbers and answers. They change nothing.

A token is shown once, when it is made. The database has its digest, so that a copy of it opens
nothing. It reads what adjudicators read, of all studies, until it runs out or is revoked.
"""

from __future__ import annotations

import hashlib
import re
import secrets
from collections.abc import Sequence

from sqlalchemy import or_, select, update
from sqlalchemy.orm import Session

from annotation_app.core.problems import Refusal
from annotation_app.core.random_ids import new_id
from annotation_app.store.audit import note
from annotation_app.store.installation import now
from annotation_app.store.models import ApiToken

DAY_S = 86_400.0
DAYS, MOST_DAYS = 365, 3650
PREFIX = "ctread_"
"""Prefix by which people, and programs that look for lost secrets, recognise a token."""
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,59}")
HOUR_S = 3600.0


def make_token(session: Session, name: str, days: float = DAYS, *, actor: str) -> str:
    """Return a new token, which can't be shown again.

    Lists and the audit trail call the program by the name. Refused if that can't be one, or another
    token has it.
    """
    if not NAME.fullmatch(name):
        raise Refusal(
            422, "This can't be a token's name. Use letters, digits and . _ - (at most 60)."
        )
    if session.scalar(select(ApiToken.id).where(ApiToken.name == name)) is not None:
        raise Refusal(422, "There is a token with this name. Use another one, or revoke that one.")
    token = PREFIX + secrets.token_urlsafe(32)
    session.add(
        ApiToken(
            id=new_id(),
            name=name,
            digest=digest_of(token),
            made_by=actor,
            made_at=now(),
            expires_at=now() + days * DAY_S,
        )
    )
    session.flush()
    note(session, actor, "made a token", name, days=days)
    return token


def tokens(session: Session) -> Sequence[ApiToken]:
    """Return all tokens that haven't been revoked, by their names."""
    return session.scalars(select(ApiToken).order_by(ApiToken.name)).all()


def revoke_token(session: Session, name: str, *, actor: str) -> None:
    """Let a token read nothing any more, from now on; refused if there is none of this name."""
    found = session.scalars(select(ApiToken).where(ApiToken.name == name)).first()
    if found is None:
        raise Refusal(404, "There is no such token. Look at the list of tokens.")
    session.delete(found)
    session.flush()
    note(session, actor, "revoked a token", name)


def find_token(session: Session, token: str) -> ApiToken | None:
    """Return the token that a program has sent, if it still is one."""
    found = session.scalars(select(ApiToken).where(ApiToken.digest == digest_of(token))).first()
    return found if found is not None and found.expires_at > now() else None


def is_newly_used(found: ApiToken) -> bool:
    """Check that no use of a token within the hour is noted yet."""
    return found.used_at is None or found.used_at + HOUR_S <= now()


def note_use(session: Session, found: ApiToken) -> None:
    """Keep, and note in the audit trail, that a token is used; once an hour."""
    used = (
        update(ApiToken)
        .where(
            ApiToken.id == found.id,
            or_(ApiToken.used_at.is_(None), ApiToken.used_at <= now() - HOUR_S),
        )
        .values(used_at=now())
        .returning(ApiToken.id)
    )
    if session.scalar(used) is not None:
        note(session, actor_of(found), "read with a token")


def actor_of(found: ApiToken) -> str:
    """Return the name of a program in the audit trail."""
    return f"token {found.name}"


def digest_of(token: str) -> str:
    """Return the digest of a token, which is kept instead of it."""
    return hashlib.sha256(token[:1000].encode()).hexdigest()
