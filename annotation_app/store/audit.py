"""The audit trail: who signed in, exported, paid, blocked or erased, and when."""

from __future__ import annotations

from collections.abc import Sequence

from sqlalchemy import or_, select, update
from sqlalchemy.orm import Session

from annotation_app.store.installation import now
from annotation_app.store.models import AuditEntry, Person, Record

COMMAND_LINE = "command line"
"""Actor of commands on the machine."""
RESTORED = "restored"
"""The action after which a ledger of payments may be behind what was done."""
SUBJECT_CHARACTERS = 12


def name_of(person: Person) -> str:
    """Return a person's name in the audit trail: their login, else their subject as in exports."""
    return person.login or person.external_hash[:SUBJECT_CHARACTERS]


def note(
    session: Session, actor: str, action: str, about: str = "", **details: Record | str | float
) -> None:
    """Note that somebody did something, in the transaction that does it.

    The actor is a login or :data:`COMMAND_LINE`, the action a verb in the past such as ``signed
    in``, and `about` a study, a login or a subject. The details are never a password, a link or
    what somebody typed.
    """
    entry = AuditEntry(at=now(), actor=actor, action=action, about=about[:200], details=details)
    session.add(entry)


def forget(session: Session, person: Person) -> None:
    """Name somebody whose data are erased by their random id wherever they are named."""
    names = [name for name in (person.login, person.external_hash[:SUBJECT_CHARACTERS]) if name]
    for column in (AuditEntry.actor, AuditEntry.about):
        session.execute(update(AuditEntry).where(column.in_(names)).values({column: person.id}))


def trail(
    session: Session,
    *,
    person: str = "",
    action: str = "",
    before: int | None = None,
    most: int = 100,
) -> Sequence[AuditEntry]:
    """Return the noted actions, newest first.

    Only what a login, or another name, did or what was done to it; only an action; only entries
    that were noted before an entry's id.
    """
    wanted = select(AuditEntry).order_by(AuditEntry.id.desc()).limit(most)
    if person:
        wanted = wanted.where(or_(AuditEntry.actor == person, AuditEntry.about == person))
    if action:
        wanted = wanted.where(AuditEntry.action == action)
    if before is not None:
        wanted = wanted.where(AuditEntry.id < before)
    return session.scalars(wanted).all()


def actions(session: Session) -> Sequence[str]:
    """Return every noted action, in alphabetical order."""
    return session.scalars(select(AuditEntry.action).distinct().order_by(AuditEntry.action)).all()
