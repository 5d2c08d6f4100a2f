"""A study of many answers, written in bulk."""

from __future__ import annotations

import numpy as np
from sqlalchemy import insert
from sqlalchemy.orm import Session

from annotation_app.core.random_ids import new_id
from annotation_app.store.models import Answer, Event, Handout, Item, Person, Slot, Study, queue_of
from annotation_app.studies.study_file import StudyConfig, TaskConfig, stored
from annotation_app.work.answer_flags import odd_below
from annotation_app.work.answer_reading import gist_of

PER_ITEM, PER_PERSON, VIDEOS = 5, 200, 50
"""Answers to an item, and by a person."""
OPEN = 0.2
"""Share of the items that wait for one more answer."""
BEGIN = 1_700_000_000.0
"""A second before the first answer; one comes each second."""


def fill(session: Session, answers: int, name: str = "load") -> str:
    """Add a study whose items have been rated by people, in bulk; return its id."""
    config = StudyConfig(name=name, title="Load", tasks={"rate": TaskConfig(answers=PER_ITEM)})
    study = new_id()
    about = {"id": study, "name": name, "config": stored(config), "created_at": BEGIN}
    session.execute(insert(Study), [about])
    luck = np.random.default_rng(0)
    people = [new_id() for _ in range(max(answers // PER_PERSON, PER_ITEM) + 1)]
    common = {"role": "worker", "provider": "load", "profile": {}, "created_at": BEGIN}
    session.execute(insert(Person), [{**common, "id": p, "external_hash": p} for p in people])
    queue = queue_of(study, "rate")
    items, slots, events, given, handouts = [], [], [], [], []
    for i in range(answers // PER_ITEM):
        item = new_id()
        payload = {
            "video": f"video-{i % VIDEOS}",
            "own_video": f"video-{i % VIDEOS}",
            "text": f"Take pallet {i} from the truck to the shelf on the left.",
        }
        items.append(
            {"id": item, "study_id": study, "task": "rate", "subject": f"{i}", "payload": payload,
             "rank": luck.random()}
        )  # fmt: skip
        usual = int(luck.integers(1, 6))
        for j in range(PER_ITEM):
            who = people[(i + j * 7) % len(people)] if len(people) > 40 else people[j]
            number = i * PER_ITEM + j + 1
            seconds = round(float(luck.lognormal(3, 0.5)), 3)
            rating = int(np.clip(usual + luck.integers(-1, 2), 1, 5))
            body = {"rating": rating, "watched_s": round(seconds / 2, 2), "speed": 1.0}
            common = {"item_id": item, "person_id": who, "at": BEGIN + number}
            events.append({**common, "id": number, "uuid": f"{number}", "name": "submit",
                           "body": body})  # fmt: skip
            given.append(
                {**common, "id": number, "task": "rate", "subject": f"{i}", "event_id": number,
                 "study_id": study, "kind": "usual", "body": body, "gist": gist_of("rate", body),
                 "surplus": False, "adopted": True, "seconds": seconds,
                 "odd_below_s": odd_below(payload, body, None), "provenance": None}
            )  # fmt: skip
            slots.append({"item_id": item, "person_id": who, "expires_at": BEGIN, "answered": True,
                          "queue": queue, "rank": items[-1]["rank"]})  # fmt: skip
            handouts.append({**common, "skipped_at": None})
        if luck.random() < OPEN:
            slots.append({"item_id": item, "person_id": None, "expires_at": None, "answered": False,
                          "queue": queue, "rank": items[-1]["rank"]})  # fmt: skip
    tables = (Item, items), (Slot, slots), (Event, events), (Answer, given), (Handout, handouts)
    for table, new in tables:
        session.execute(insert(table), new)
    return study
