"""What a page gets to know of an item."""

from __future__ import annotations

from sqlalchemy import and_, bindparam, select
from sqlalchemy.orm import Session

from annotation_app.store.models import Draft, Item, Record
from annotation_app.tasks.task_registry import task_of

_ITEM = (
    select(Item, Draft)
    .outerjoin(Draft, and_(Draft.item_id == Item.id, Draft.person_id == bindparam("who")))
    .where(Item.id == bindparam("item"))
)


def page_data(session: Session, item_id: str, who: str, salt: bytes) -> Record:
    """What an item's page gets: ``item``, ``task``, ``draft``, and its task's ``payload``."""
    item, draft = session.execute(_ITEM, {"item": item_id, "who": who}).one()
    return {
        "item": item.id,
        "task": item.task,
        "draft": None if draft is None else {"revision": draft.revision, "body": draft.body},
        "payload": task_of(item.task).payload(session, item, salt),
    }
