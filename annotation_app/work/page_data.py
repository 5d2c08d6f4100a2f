"""Data of an item's page, the program's suggestion there, and the suggestion's provenance.

An offer is ``{"state", "suggestion"}``, kept with the handout when somebody first opens an item's
page. So it stays as they saw it, even if the program or the study's file changes. States:

- ``shown``: the person saw the suggestion;
- ``unsure``: there is one, less probable than what the study shows;
- ``withheld``: there is one, and the draw of a study with ``half`` has left it out;
- ``off``: the study shows none;
- ``none``: the program had nothing to suggest, isn't installed, or doesn't know the language.

An answer's provenance is ``{"suggestion": state, "likeness", "unchanged"}``, the last two where
there is a suggestion, and ``"fates"`` where its task compares the suggestion's parts. So answers
can also be compared with suggestions that nobody saw.
"""

from __future__ import annotations

from typing import Any

from sqlalchemy import Engine, and_, bindparam, select, update
from sqlalchemy.orm import Session

from annotation_app.core.languages import SOURCE
from annotation_app.items.assignment import AnyItem
from annotation_app.items.new_items import draws
from annotation_app.store.database import reading, transaction
from annotation_app.store.models import Draft, Handout, Item, Record, Study, TaskName
from annotation_app.studies.study_file import StudyConfig, restored
from annotation_app.tasks.task_registry import task_of
from annotation_app.work.handing_out import task_config

_ITEM = (
    select(Item, Draft)
    .outerjoin(Draft, and_(Draft.item_id == Item.id, Draft.person_id == bindparam("who")))
    .where(Item.id == bindparam("item"))
)


def page_data(session: Session, item_id: str, who: str, salt: bytes) -> Record:
    """Return the data of an item's page: ``item``, ``task``, ``draft``, and the ``payload``."""
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
    """Return the page's data for an item's holder, and keep the suggestion offered to them."""
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


def new_offer(session: Session, config: StudyConfig, item: Item) -> Record | None:
    """Return the offer for an item; None if its task has no suggestions."""
    task = task_of(item.task)
    if task.suggestion is None:
        return None
    wanted = task_config(config, item.task).suggestions
    if wanted == "off":
        return {"state": "off", "suggestion": None}
    is_understood = not task.suggests_in_english or config.locale.split("-")[0] == SOURCE
    found = task.suggestion(session, item) if is_understood else None
    if found is None:
        return {"state": "none", "suggestion": None}
    is_shown = wanted == "on" or draws(config, f"suggestion for {item.id}").random() < 0.5
    state = "shown" if is_shown else "withheld"
    if found.probability is not None and found.probability < _least(config, item.task):
        state = "unsure"
    return {"state": state, "suggestion": found.value}


def _least(config: StudyConfig, task_name: TaskName) -> float:
    least = task_config(config, task_name).suggestions_from
    return task_of(task_name).suggested_from if least is None else least


def seen(session: Session, item: Item, offer: Record | None, salt: bytes) -> Any:
    """Return the part of an offer that a person sees; None if it is withheld."""
    if offer is None or offer["state"] != "shown":
        return None
    return task_of(item.task).shown_suggestion(session, item, offer["suggestion"], salt)


def offered(session: Session, item_id: str, who: str) -> Record | None:
    """Return the offer made to a person."""
    return session.scalar(
        select(Handout.offer).where(Handout.item_id == item_id, Handout.person_id == who)
    )


def keep_offer(session: Session, item_id: str, who: str, offer: Record) -> None:
    """Keep what is offered to somebody, unless something was before."""
    session.execute(
        update(Handout)
        .where(Handout.item_id == item_id, Handout.person_id == who, Handout.offer.is_(None))
        .values(offer=offer)
    )


def provenance(session: Session, item: AnyItem, who: str, body: Record) -> Record | None:
    """Return a suggestion's relation to a person's answer; None if they were offered nothing."""
    task = task_of(item.task)
    if task.likeness is None:
        return None
    offer = offered(session, item.id, who)
    if offer is None:
        return None
    if offer["suggestion"] is None:
        return {"suggestion": offer["state"]}
    likeness = task.likeness(offer["suggestion"], body)
    fates = {} if task.fates is None else {"fates": task.fates(offer["suggestion"], body)}
    return {
        "suggestion": offer["state"],
        "unchanged": likeness == 1.0,
        "likeness": round(likeness, 3),
        **fates,
    }
