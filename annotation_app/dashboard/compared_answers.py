"""The answers of a study that are compared with each other."""

from __future__ import annotations

from typing import Any

from sqlalchemy import Select, select

from annotation_app.store.models import Answer, Event, Item


def compared_answers(study_id: str, *columns: Any) -> Select[Any]:
    """A statement for columns of answers, items and events, in the answers' order.

    Attention checks and answers that are left out don't count, nor do adjudicators: they have seen
    what the others answered.
    """
    return (
        select(*columns)
        .select_from(Answer)
        .join(Item, Item.id == Answer.item_id)
        .join(Event, Event.id == Answer.event_id)
        .where(
            Item.study_id == study_id,
            Item.attention.is_(False),
            Answer.excluded.is_(False),
            Event.name != "adjudicate",
        )
        .order_by(Answer.id)
    )
