"""Telling webhooks of finished items: messages are written in the transaction that finishes them.

An item is finished when all answers that were asked for are there, and whenever an adjudicator
decides. ``annotation_app.serving.webhook_delivery`` sends the messages.
"""

from __future__ import annotations

from typing import Literal, TypeAlias
from uuid import uuid4

from sqlalchemy import bindparam, select
from sqlalchemy.orm import Session

from annotation_app.store.database import core
from annotation_app.store.models import Answer, Item, Slot
from annotation_app.store.program_models import Webhook, WebhookMessage
from annotation_app.tasks.task_registry import task_of

About: TypeAlias = Literal["adopted", "answered", "in dispute"]

WEBHOOK = core(Webhook)
_WEBHOOKS = select(WEBHOOK.c.id).where(WEBHOOK.c.study_id == bindparam("study"))
_ITEM = select(Item).where(Item.id == bindparam("item")).with_for_update(key_share=True)
_OPEN = select(Slot.id).where(Slot.item_id == bindparam("item"), Slot.answered.is_(False)).limit(1)
_ADOPTED = select(Answer.id).where(Answer.item_id == bindparam("item"), Answer.adopted).limit(1)


def after_answer(session: Session, study_id: str, item_id: str, answer: int, *, now: float) -> None:
    """Tell of an item if an accepted answer was the last that was asked for."""
    if not session.scalars(_WEBHOOKS, {"study": study_id}).first():
        return
    # Of two who send the last answers at the same moment one waits, and sees the other's.
    item = session.scalars(_ITEM, {"item": item_id}).one()
    if item.attention or session.scalar(_OPEN, {"item": item_id}) is not None:
        return
    about: About = "answered"
    if task_of(item.task).adjudication is not None:
        adopted = session.scalar(_ADOPTED, {"item": item_id})
        answer, about = (adopted, "adopted") if adopted is not None else (answer, "in dispute")
    finished(session, study_id, item_id, about, answer, now=now)


def finished(
    session: Session, study_id: str, item_id: str, about: About, answer: int, *, now: float
) -> None:
    """Write a message about an item for each webhook of its study."""
    session.add_all(
        WebhookMessage(
            id=str(uuid4()),
            webhook_id=webhook,
            item_id=item_id,
            answer_id=answer,
            about=about,
            made_at=now,
            state="waiting",
            next_at=now,
        )
        for webhook in session.scalars(_WEBHOOKS, {"study": study_id}).all()
    )
