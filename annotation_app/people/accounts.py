"""Logins: who may sign in with which password, and as what."""

from __future__ import annotations

import re
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

from sqlalchemy import delete, func, select
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session
from werkzeug.security import check_password_hash, generate_password_hash

from annotation_app.core.languages import gettext
from annotation_app.core.problems import Refusal
from annotation_app.people import failed_sign_ins
from annotation_app.people.browser_sessions import end_sessions
from annotation_app.people.participants import LOGIN, add_person
from annotation_app.store.audit import COMMAND_LINE, name_of, note
from annotation_app.store.database import lock_set_up
from annotation_app.store.installation import now
from annotation_app.store.models import AccountLink, AuditEntry, Person, Role

State: TypeAlias = Literal["active", "blocked", "no password yet"]

ROLES: tuple[Role, ...] = ("annotator", "adjudicator", "admin")
"""Roles of people with a login, each with more rights than those before."""
SHORTEST_PASSWORD, LONGEST_PASSWORD = 10, 200
LONGEST_LOGIN = 100
ADMIN_PASSWORD, ADMIN_LOGIN = "ANNOTATE_ADMIN_PASSWORD", "ANNOTATE_ADMIN_LOGIN"
"""Environment variables of the first admin, who is made without a link."""

_METHOD = "scrypt:32768:8:1"
_NOBODY = f"{_METHOD}${'0' * 16}${'0' * 128}"
"""Checked where there is no such login, so that time doesn't show which logins there are."""


@dataclass(frozen=True, slots=True)
class Account:
    """A person with a login; times are in seconds since 1970, None before the first sign-in."""

    person_id: str
    login: str
    role: Role
    state: State
    added_at: float
    last_signed_in: float | None


def clean_login(login: str) -> str:
    """Return a login as it is kept: capitals and spaces around it don't matter."""
    return login.strip().casefold()


def add_login(
    session: Session, login: str, role: Role, password: str | None = None, *, actor: str
) -> Person:
    """Add somebody who signs in, with a password or until they set one by a link.

    Refused if the login is taken or can't be one, or the password can't be one.
    """
    name = clean_login(login)
    if not 1 <= len(name) <= LONGEST_LOGIN or not name.isprintable():
        raise Refusal(
            422,
            gettext(
                "A login has 1 to %(most)s characters. Choose another one.", most=LONGEST_LOGIN
            ),
        )
    if password is not None:
        check_password(password, name)
    taken = Refusal(422, gettext("This login is taken. Choose another one."))
    if find(session, name) is not None:
        raise taken
    kept = None if password is None else _hashed(password)
    # Nobody is looked for by this hash. It is random, so that a login that was removed can be
    # given to somebody else, who is another person.
    random = secrets.token_hex(32)
    try:
        with session.begin_nested():
            person = add_person(session, LOGIN, random, role, login=name, password_hash=kept)
    except IntegrityError:  # it was taken by another request at the same time
        raise taken from None
    note(session, actor, "added", name, role=role)
    return person


def check_password(password: str, login: str) -> None:
    """Refuse passwords that are too short, too long, or easy to guess, as by their login."""
    if not SHORTEST_PASSWORD <= len(password) <= LONGEST_PASSWORD:
        raise Refusal(
            422,
            gettext(
                "A password has %(least)s to %(most)s characters. Choose another one.",
                least=SHORTEST_PASSWORD,
                most=LONGEST_PASSWORD,
            ),
        )
    if is_guessable(password, login):
        raise Refusal(
            422,
            gettext(
                "This password is easy to guess. Choose one without your login, usual words, "
                "rows of keys and repetitions, such as four words that don't belong together."
            ),
        )


def find(session: Session, login: str) -> Person | None:
    """Return the person with a login."""
    return session.scalars(select(Person).where(Person.login == clean_login(login))).first()


def required_login(session: Session, login: str) -> Person:
    """Return the person with a login; refused if there is none."""
    person = find(session, login)
    if person is None:
        raise Refusal(404, "Nobody has this login. List all with: ct annotate people list.")
    return person


def matching(session: Session, login: str, password: str) -> Person | None:
    """Return the person with a login and password, even if blocked. A miss takes as long."""
    person = find(session, login)
    known = person.password_hash if person is not None and person.password_hash else _NOBODY
    return person if check_password_hash(known, password[:LONGEST_PASSWORD]) else None


def set_password(session: Session, person: Person, password: str, *, actor: str) -> None:
    """Give somebody a new password, if it can be one. Their sessions end, and so does any wait."""
    check_password(password, person.login or "")
    person.password_hash = _hashed(password)
    _forget_access(session, person)
    note(session, actor, "password changed", person.login or "")


def change_role(session: Session, person: Person, role: Role, *, actor: str) -> None:
    """Let somebody do what a role may; they must sign in again. Refused for the last admin."""
    if role == person.role:
        return
    if role != "admin":
        _keep_an_admin(session, person)
    before, person.role = person.role, role
    end_sessions(session, person)
    note(session, actor, "role changed", name_of(person), role=role, before=before)


def block(session: Session, person: Person, *, actor: str) -> None:
    """Let somebody but the last admin do no more. Workers may still send what they have."""
    _keep_an_admin(session, person)
    person.blocked_at = now()
    if person.login is not None:
        _forget_access(session, person)
    note(session, actor, "blocked", name_of(person))


def unblock(session: Session, person: Person, *, actor: str) -> None:
    """Unblock somebody, and end the wait after wrong passwords."""
    person.blocked_at = None
    if person.login is not None:
        failed_sign_ins.forget(session, person.login)
    note(session, actor, "unblocked", name_of(person))


def reset(session: Session, person: Person, *, actor: str) -> None:
    """Take somebody's password away; a link lets them set a new one."""
    person.password_hash = None
    _forget_access(session, person)
    note(session, actor, "reset", name_of(person))


def remove(session: Session, person: Person, *, actor: str) -> None:
    """Take somebody's login away. What they have answered stays. Refused for the last admin."""
    _keep_an_admin(session, person)
    _forget_access(session, person)
    note(session, actor, "removed", name_of(person))
    person.login, person.password_hash, person.role = None, None, "worker"
    session.flush()


def has_admin(session: Session) -> bool:
    """Check that there is an admin who can sign in."""
    return session.scalar(select(func.count()).where(*_ACTIVE_ADMIN)) != 0


def admin_from_environment(session: Session, environment: Mapping[str, str]) -> Person | None:
    """Make the first admin as the environment says; None if it doesn't, or there is an admin.

    A FormatError says that the login or the password can't be one.
    """
    password = environment.get(ADMIN_PASSWORD)
    if not password:
        return None
    lock_set_up(session.connection())
    if has_admin(session):
        return None
    login = environment.get(ADMIN_LOGIN) or "admin"
    try:
        return add_login(session, login, "admin", password, actor=COMMAND_LINE)
    except Refusal as refusal:
        raise refusal.as_error(f"{ADMIN_PASSWORD} and {ADMIN_LOGIN}") from None


def accounts(session: Session) -> list[Account]:
    """Return everybody with a login."""
    signed_in = (
        select(AuditEntry.actor, func.max(AuditEntry.at).label("at"))
        .where(AuditEntry.action == "signed in")
        .group_by(AuditEntry.actor)
        .subquery()
    )
    rows = session.execute(
        select(Person, signed_in.c.at)
        .outerjoin(
            signed_in,
            (signed_in.c.actor == Person.login) & (signed_in.c.at >= Person.created_at),
        )
        .where(Person.login.is_not(None))
        .order_by(Person.login)
    )
    return [
        Account(person.id, str(person.login), person.role, _state(person), person.created_at, at)
        for person, at in rows
    ]


def _state(person: Person) -> State:
    if person.blocked_at is not None:
        return "blocked"
    return "active" if person.password_hash else "no password yet"


_ACTIVE_ADMIN = (
    Person.role == "admin",
    Person.password_hash.is_not(None),
    Person.blocked_at.is_(None),
)


def _keep_an_admin(session: Session, person: Person) -> None:
    if person.role != "admin" or not person.password_hash or person.blocked_at is not None:
        return
    lock_set_up(session.connection())  # two admins could block each other
    others = select(func.count()).where(*_ACTIVE_ADMIN, Person.id != person.id)
    if not session.scalar(others):
        raise Refusal(
            422,
            "This is the last admin. Make another admin first, with: "
            "ct annotate people invite --role admin.",
        )


def _forget_access(session: Session, person: Person) -> None:
    """End somebody's sessions, links and waits."""
    session.execute(delete(AccountLink).where(AccountLink.person_id == person.id))
    failed_sign_ins.forget(session, person.login or "")
    end_sessions(session, person)


def _hashed(password: str) -> str:
    return generate_password_hash(password, method=_METHOD)


FEWEST_CHARACTERS = 5
"""A password has so many different characters, and so many that aren't easy to guess."""
_RUN = 3
"""Least number of characters in a known order that count as one thing."""
_ROWS = (
    "abcdefghijklmnopqrstuvwxyz",
    "01234567890",
    "qwertyuiop",
    "qwertzuiop",
    "azertyuiop",
    "asdfghjkl",
    "zxcvbnm",
    "yxcvbnm",
    "qazwsxedcrfvtgb",
    "1q2w3e4r5t6y7u8i9o0p",
    "1qaz2wsx3edc4rfv",
)
_WORDS = (  # noqa: SIM905 - a line for each would be fifty
    "password passwort passwd geheim secret hallo hello world welcome willkommen letmein login "
    "admin administrator root user guest gast master default changeme change temp test testing "
    "iloveyou love liebe dragon monkey football baseball fussball princess sunshine shadow "
    "superman batman summer sommer winter spring autumn herbst monday montag freedom whatever "
    "trustno access annotate annotation annotator adjudicator worker corpus study robot forklift "
    "schatz qwerty qwertz computer internet google"
).split()
_LOOKS_LIKE = str.maketrans("@$!|0134578", "asiloieastb")
"""Signs that stand for letters."""


def is_guessable(password: str, login: str) -> bool:
    """Check that a password is among those that are tried first.

    >>> is_guessable("aaaaaaaaaa", "maria"), is_guessable("Passw0rd2024", "maria")
    (True, True)
    >>> is_guessable("maria12345", "maria"), is_guessable("correct horse battery", "maria")
    (True, False)
    """
    text = password.casefold()
    if len(set(text)) < FEWEST_CHARACTERS:
        return True
    text = _once(re.sub(r"\s+", "", text))
    text = re.sub(r"(?:19|20)\d\d", "", text)
    name = re.sub(r"\s+", "", login.strip().casefold())
    for known in sorted({*_WORDS, name, name[::-1]}, key=len, reverse=True):
        if len(known) >= _RUN:
            text = text.replace(known, "")
            if known in (plain := text.translate(_LOOKS_LIKE)):
                start = plain.index(known)
                text = text[:start] + text[start + len(known) :]
    text = _without_runs(re.sub(r"(.)\1+", r"\1", text))
    return len(set(re.sub(r"\W", "", text))) < FEWEST_CHARACTERS


def _once(text: str) -> str:
    """Return a text with immediate repetitions written once."""
    for length in range(1, len(text) // 2 + 1):
        if all(text[i] == text[i % length] for i in range(length, len(text))):
            return text[:length]
    return text


def _without_runs(text: str) -> str:
    """Remove runs of keys, of letters in order and of digits in order, in either direction."""
    rows = [*_ROWS, *(row[::-1] for row in _ROWS)]
    kept, at = "", 0
    while at < len(text):
        longest = max(
            (
                n
                for n in range(_RUN, len(text) - at + 1)
                if any(text[at : at + n] in r for r in rows)
            ),
            default=1,
        )
        kept += text[at] if longest == 1 else ""
        at += longest
    return kept
