"""The tables for other programs: tokens, webhooks, and messages to these."""

from __future__ import annotations

from typing import Literal

from sqlalchemy import ForeignKey, Index, String, text
from sqlalchemy.orm import Mapped, mapped_column

from annotation_app.store.models import Base


class ApiToken(Base):
    """By which a program reads what people with a login may read. It changes nothing.

    Only its digest is kept. It belongs to the installation, not to whoever made it.
    """

    __tablename__ = "api_token"

    id: Mapped[str] = mapped_column(primary_key=True)
    name: Mapped[str] = mapped_column(unique=True)
    """What the audit trail calls the program."""
    digest: Mapped[str] = mapped_column(unique=True)
    made_by: Mapped[str]
    made_at: Mapped[float]
    expires_at: Mapped[float]
    used_at: Mapped[float | None]
    """To the hour."""


class Webhook(Base):
    """An address that is notified of a study's finished items.

    Its secret is made of its id and the installation's key: no copy of the database has it.
    """

    __tablename__ = "webhook"

    id: Mapped[str] = mapped_column(primary_key=True)
    study_id: Mapped[str] = mapped_column(ForeignKey("study.id"), index=True)
    url: Mapped[str] = mapped_column(String(2000))
    links_to: Mapped[str] = mapped_column(String(2000))
    """Where people reach the app: links in messages begin with it."""
    with_answers: Mapped[bool]
    """Whether messages have what people answered."""
    allows_private: Mapped[bool]
    """Whether it may lead to the machine itself, or into a private network."""
    made_by: Mapped[str]
    made_at: Mapped[float]


class WebhookMessage(Base):
    """A message to a webhook. It is written together with the answer that it reports."""

    __tablename__ = "webhook_message"
    __table_args__ = (Index("ix_webhook_message_due", "state", "next_at"),)

    id: Mapped[str] = mapped_column(primary_key=True)
    """The same each time it is sent, so that whoever gets it twice can tell."""
    webhook_id: Mapped[str] = mapped_column(ForeignKey("webhook.id"), index=True)
    item_id: Mapped[str] = mapped_column(ForeignKey("item.id"))
    answer_id: Mapped[int | None]
    """The answer by which the item was finished."""
    about: Mapped[Literal["adopted", "answered", "in dispute"]] = mapped_column(String(20))
    """What became of the item."""
    made_at: Mapped[float]
    state: Mapped[Literal["waiting", "sent", "given up"]] = mapped_column(String(20))
    attempts: Mapped[int] = mapped_column(default=0, server_default=text("0"))
    next_at: Mapped[float]
    """When to try next; while somebody sends it, when others may."""
    ended_at: Mapped[float | None]
    problem: Mapped[str] = mapped_column(String(500), default="", server_default="")
    """Why the last attempt failed."""
