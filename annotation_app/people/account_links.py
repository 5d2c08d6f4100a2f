"""Links that can be used once: to make the first admin, to make a login, to set a password.

Only digests of them are in the database. So any of several processes can make and take
them, and a copy of the database opens nothing.
"""

from __future__ import annotations

import secrets
from collections.abc import Sequence

from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from annotation_app.core.languages import gettext
from annotation_app.core.problems import Refusal
from annotation_app.people.accounts import add_login, has_admin, set_password
from annotation_app.people.api_tokens import DAY_S, digest_of
from annotation_app.store.audit import COMMAND_LINE, note
from annotation_app.store.database import lock_set_up
from annotation_app.store.installation import now
from annotation_app.store.models import AccountLink, Person, Role

FIRST_ADMIN_S = DAY_S
INVITATION_DAYS = 7


def path_of(token: str) -> str:
    """Return the path of a link in the app."""
    return f"/setup/{token}"


def first_admin_link(session: Session) -> str | None:
    """Return the token of a link that makes the first admin; None if there is an admin.

    Each process that starts makes one. All are of no use any more once there is an admin.
    """
    lock_set_up(session.connection())
    if has_admin(session):
        return None
    link = AccountLink(purpose="first admin", role="admin", made_by=COMMAND_LINE)
    return _made(session, link, FIRST_ADMIN_S)


def invite(session: Session, role: Role, days: float = INVITATION_DAYS, *, actor: str) -> str:
    """Return the token of a link by which somebody chooses a login with a role."""
    note(session, actor, "invited", role=role)
    return _made(session, AccountLink(purpose="invite", role=role, made_by=actor), days * DAY_S)


def password_link(
    session: Session, person: Person, days: float = INVITATION_DAYS, *, actor: str
) -> str:
    """Return the token of a link by which somebody sets their password; earlier ones are void."""
    session.execute(delete(AccountLink).where(AccountLink.person_id == person.id))
    link = AccountLink(purpose="reset", person_id=person.id, made_by=actor)
    return _made(session, link, days * DAY_S)


def read_link(session: Session, token: str) -> tuple[AccountLink, Person | None]:
    """Return a link's purpose, and the person whose password it sets; refused if it is void."""
    link = session.get(AccountLink, digest_of(token))
    if link is None or link.expires_at <= now():
        raise _gone(session)
    person = None if link.person_id is None else session.get(Person, link.person_id)
    if link.purpose == "reset" and (person is None or person.login is None):
        raise _gone(session)
    if link.purpose == "first admin" and has_admin(session):
        raise _gone(session)
    return link, person


def use_link(session: Session, token: str, login: str, password: str) -> Person:
    """Make the login, or set the password, that a link is for. The link is used up.

    No login is needed where only a password is set. Refused if the link isn't one any more, or
    the login or the password can't be one.
    """
    # Two people who open a link at the same time come here one after the other.
    lock_set_up(session.connection())
    link, person = read_link(session, token)
    used = delete(AccountLink).where(AccountLink.digest == link.digest)
    if person is not None:
        session.execute(used)
        set_password(session, person, password, actor=person.login or "")
        return person
    role: Role = link.role or "annotator"
    person = add_login(session, login, role, password, actor=link.made_by)
    if link.purpose == "first admin":
        used = delete(AccountLink).where(AccountLink.purpose == "first admin")
    session.execute(used)
    return person


def open_invitations(session: Session) -> Sequence[AccountLink]:
    """Return the unused invitations, those that run out first before others."""
    return session.scalars(
        select(AccountLink)
        .where(AccountLink.purpose == "invite", AccountLink.expires_at > now())
        .order_by(AccountLink.expires_at)
    ).all()


def withdraw(session: Session, digest: str, *, actor: str) -> None:
    """Make an invitation void; refused if there is no such invitation any more."""
    link = session.get(AccountLink, digest)
    if link is None or link.purpose != "invite":
        raise Refusal(404, "This invitation has been used or has run out.")
    session.delete(link)
    session.flush()
    note(session, actor, "invitation withdrawn", role=link.role or "")


def _made(session: Session, link: AccountLink, holds_s: float) -> str:
    session.execute(delete(AccountLink).where(AccountLink.expires_at <= now()))
    token = secrets.token_urlsafe(24)
    link.digest = digest_of(token)
    link.made_at = now()
    link.expires_at = link.made_at + holds_s
    session.add(link)
    session.flush()
    return token


def _gone(session: Session) -> Refusal:
    new = (
        gettext("Ask for a new one.")
        if has_admin(session)
        else gettext(
            "A new one is made on the server with: ct annotate people invite --role admin."
        )
    )
    gone = gettext("This link has been used, has run out, or isn't complete.")
    return Refusal(404, f"{gone} {new}")
