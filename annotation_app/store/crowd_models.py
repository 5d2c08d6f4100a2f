"""The tables of crowd platforms: assignments there, and a ledger of what is offered and paid."""

from __future__ import annotations

from typing import Literal

from sqlalchemy import ForeignKey, String, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column

from annotation_app.store.models import Base, Record, TaskName


class Participation(Base):
    """A person's assignment at a crowd platform: received here, and confirmed there."""

    __tablename__ = "participation"
    __table_args__ = (UniqueConstraint("provider", "assignment"),)

    id: Mapped[int] = mapped_column(primary_key=True, autoincrement=True)
    study_id: Mapped[str] = mapped_column(ForeignKey("study.id"))
    person_id: Mapped[str] = mapped_column(ForeignKey("person.id"))
    provider: Mapped[str]
    assignment: Mapped[str]
    """The platform's id of the assignment, which says nothing about the person."""
    task: Mapped[TaskName] = mapped_column(String(20))
    items: Mapped[int]
    """Number of items of the task in the assignment."""
    code: Mapped[str | None]
    begun_at: Mapped[float]
    received_at: Mapped[float | None]
    confirmed_at: Mapped[float | None]
    standing: Mapped[
        Literal["working", "submitted", "approved", "rejected", "returned", "unknown"] | None
    ] = mapped_column(String(20))
    """Platform's last status: ``unknown`` if it has no such one, None without a comparison."""
    outcome: Mapped[Record]
    """Further details: the address to send the worker back to, or that no items were left."""


class LedgerEntry(Base):
    """A call to a platform that offers work, approves, rejects or pays, noted before it is made.

    A platform's offer or payment that wasn't made from here is noted when it is discovered.

    Rows are never deleted, also not when a person's data are erased: books must be kept.
    """

    __tablename__ = "ledger"
    __table_args__ = (UniqueConstraint("provider", "what", "key"),)

    id: Mapped[int] = mapped_column(primary_key=True, autoincrement=True)
    study_id: Mapped[str] = mapped_column(ForeignKey("study.id"), index=True)
    participation_id: Mapped[int | None] = mapped_column(ForeignKey("participation.id"))
    provider: Mapped[str]
    what: Mapped[Literal["publish", "approve", "reject", "bonus", "partial payment"]] = (
        mapped_column(String(20))
    )
    key: Mapped[str] = mapped_column(String(500))
    """Key that distinguishes calls of a kind: the same call is made once."""
    assignment: Mapped[str]
    """The platform's id of what is approved or paid by; empty for offers of work."""
    amount: Mapped[str]
    """A decimal number in the platform's currency: what is paid, or offered for an assignment.

    Empty where the call pays nothing, or an unknown amount.
    """
    reason: Mapped[str] = mapped_column(String(2000))
    reference: Mapped[str | None]
    """Platform's reference of the call: its id of the payment, or an idempotency key."""
    state: Mapped[
        Literal["attempted", "ordered", "in doubt", "done", "confirmed", "found there", "refused"]
    ] = mapped_column(String(20))
    attempted_at: Mapped[float]
    ended_at: Mapped[float | None]
    problem: Mapped[str] = mapped_column(String(2000))
    """Error of the platform or the network; empty if nothing went wrong."""
