"""What a page gets to know of an item."""

from __future__ import annotations

from sqlalchemy import Engine, and_, bindparam, select
from sqlalchemy.orm import Session

from annotation_app.store.database import reading, transaction
from annotation_app.store.models import Draft, Item, Record, Study
from annotation_app.studies.study_file import restored
from annotation_app.tasks.task_registry import task_of
from annotation_app.work.offers import keep_offer, new_offer, offered, seen

_ITEM = (
    select(Item, Draft)
    .outerjoin(Draft, and_(Draft.item_id == Item.id, Draft.person_id == bindparam("who")))
    .where(Item.id == bindparam("item"))
)


def page_data(session: Session, item_id: str, who: str, salt: bytes) -> Record:
    """What an item's page gets: ``item``, ``task``, ``draft``, and its task's ``payload``."""
    item, draft = session.execute(_ITEM, {"item": item_id, "who": who}).one()
    payload = task_of(item.task).payload(session, item, salt)
    if task_of(item.task).suggestion is not None:
        payload["suggestion"] = seen(session, item, offered(session, item_id, who), salt)
    return {
        "item": item.id,
        "task": item.task,
        "draft": None if draft is None else {"revision": draft.revision, "body": draft.body},
        "payload": payload,
    }


def opened_page(engine: Engine, item_id: str, who: str, salt: bytes) -> Record:
    """The same for somebody who has the item; what is suggested to them is kept."""
    with reading(engine) as session:
        data = page_data(session, item_id, who, salt)
        if "suggestion" not in data["payload"] or offered(session, item_id, who) is not None:
            return data
        item = session.get_one(Item, item_id)
        # It may take seconds, in which others go on writing.
        config = restored(session.get_one(Study, item.study_id).config)
        offer = new_offer(session, config, item)
    if offer is not None:
        with transaction(engine) as session:
            keep_offer(session, item_id, who, offer)
            item = session.get_one(Item, item_id)
            kept = offered(session, item_id, who)
            data["payload"]["suggestion"] = seen(session, item, kept, salt)
    return data
