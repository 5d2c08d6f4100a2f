"""The audit trail: who signed in, exported, paid, blocked or erased, and when."""

from __future__ import annotations

from sqlalchemy.orm import Session

from annotation_app.installation import now
from annotation_app.models import AuditEntry, Record

COMMAND_LINE = "command line"
"""Who acts where something is done on the machine."""


def note(
    session: Session, actor: str, action: str, about: str = "", **details: Record | str | float
) -> None:
    """Note that somebody did something, in the transaction that does it.

    Parameters
    ----------
    actor
        A login, or :data:`COMMAND_LINE`.
    action
        A verb in the past, such as ``signed in`` or ``exported``.
    about
        A study, a login or a subject.
    details
        What else is worth knowing; never a password, a link or what somebody typed.
    """
    entry = AuditEntry(at=now(), actor=actor, action=action, about=about[:200], details=details)
    session.add(entry)
