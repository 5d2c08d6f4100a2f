"""Items with suggestions, and what answers tell of them."""

from __future__ import annotations

import json
from typing import Any

from flask import Flask
from msgspec.structs import replace

from annotation_app.items.new_items import NewItem, add_item
from annotation_app.store.database import transaction
from annotation_app.store.models import Record
from annotation_app.studies.study_file import StudyConfig, Suggestions, stored
from annotation_app.work.handing_out import find_study
from tests.annotation_app.browser import COMMAND, engine_of, exported
from tests.annotation_app.rendered import VIDEOS


def put(app: Flask, study: StudyConfig, wanted: Suggestions, items: int = 1, **more: Any) -> None:
    """Have a study's one task make use of suggestions, and give it items about a command."""
    ((task, config),) = study.tasks.items()
    study = replace(study, tasks={task: replace(config, suggestions=wanted)})
    with transaction(engine_of(app)) as session:
        found = find_study(session, "tests")
        found.config = stored(study)
        for number in range(items):
            about = {"text": COMMAND, "command": number, "video": VIDEOS[0], **more}
            add_item(session, found, study, NewItem(task, f"command {number}", about))


def rows(app: Flask) -> list[Record]:
    return [json.loads(line) for line in exported(app, "jsonl").splitlines()]


def of(row: Record) -> tuple[str, bool | None, float | None]:
    return row["suggestion"], row["unchanged"], row["likeness"]
