"""Commands from a table as adopted answers, so that the study's tasks go on with them."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import replace

from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.items.new_items import GIVEN
from annotation_app.people.participants import hashed
from annotation_app.store.database import lock_set_up
from annotation_app.store.models import Item, Study
from annotation_app.study_setup.corpus_study import PROVIDER, AnswerLoader
from annotation_app.study_setup.own_videos import GivenCommand
from annotation_app.work.adoption import answered
from g3.annotation import Command

ID_CHARACTERS = 12


def put_commands(
    session: Session, study: Study, commands: Sequence[GivenCommand], salt: bytes
) -> int:
    """Add the commands that aren't there yet; how many they are."""
    lock_set_up(session.connection())
    loader = AnswerLoader(session, study, f"study {study.name}", salt)
    subjects = select(Item.subject).where(Item.study_id == study.id, Item.subject.startswith(GIVEN))
    known = set(session.scalars(subjects))
    new = []
    for rank, given in enumerate(commands):
        digest = hashlib.sha256(f"{given.video}\0{given.text}".encode()).hexdigest()
        subject = f"{GIVEN}{digest}"
        if subject in known:
            continue
        known.add(subject)
        metadata = dict(given.metadata)
        named = metadata.pop("subject", "")
        # Whoever it names is told by a hash, as everybody else.
        who = hashed(salt, PROVIDER, f"{study.name} {named}")[:ID_CHARACTERS] if named else ""
        command = Command(
            f"{study.name}-{digest[:ID_CHARACTERS]}", given.text, given.video, given.video, who
        )
        typed = loader.typed(command, given.video, rank)
        new.append(replace(typed, subject=subject, body={**typed.body, "metadata": metadata}))
    for answer in loader.answers(new):
        answered(session, answer.task, answer.id)
    return len(new)
