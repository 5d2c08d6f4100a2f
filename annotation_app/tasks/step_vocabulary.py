"""The steps that people choose from, where a study has a list of them.

A list is closed, or it grows: a new step that several people have used becomes part of it.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping

from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.store.models import Answer, Record, Study, TaskName
from annotation_app.studies.study_file import StudyConfig, restored


def has_vocabulary(config: StudyConfig) -> bool:
    """Return True if people are offered steps to choose from."""
    return bool(config.vocabulary) or config.vocabulary_grows is not None


def is_closed(config: StudyConfig) -> bool:
    """Return True if people can't use other steps than the listed ones."""
    return bool(config.vocabulary) and config.vocabulary_grows is None


def step_key(text: str) -> str:
    """Return what two spellings of a step have in common: no capitals, no full stop."""
    return " ".join(text.casefold().split()).rstrip(" .")


def listed_steps(config: StudyConfig) -> Mapping[str, str]:
    """Return the steps in a study's file by their keys."""
    return {step_key(text): text for text in config.vocabulary}


def page_vocabulary(session: Session, study_id: str, task: TaskName) -> Record | None:
    """Return the page's data of the steps to choose from; None if there is no list."""
    config = restored(session.get_one(Study, study_id).config)
    if not has_vocabulary(config):
        return None
    steps = dict(listed_steps(config))
    if config.vocabulary_grows is not None:
        steps |= _agreed(session, study_id, task, config.vocabulary_grows, steps)
    return {"steps": list(steps.values()), "closed": is_closed(config)}


def _agreed(
    session: Session, study_id: str, task: TaskName, people: int, known: Mapping[str, str]
) -> dict[str, str]:
    """Return the new steps that enough people have used, in their most frequent spelling."""
    used_by: dict[str, set[str]] = defaultdict(set)
    spellings: dict[str, Counter[str]] = defaultdict(Counter)
    rows = session.execute(
        select(Answer.person_id, Answer.body)
        .where(Answer.study_id == study_id, Answer.task == task, Answer.excluded.is_(False))
        .order_by(Answer.id)
    )
    for person, body in rows:
        for step in body["subtasks"]:
            key = step_key(step["text"])
            if key not in known:
                used_by[key].add(person)
                spellings[key][step["text"]] += 1
    return {
        key: spellings[key].most_common(1)[0][0]
        for key, who in used_by.items()
        if len(who) >= people
    }
