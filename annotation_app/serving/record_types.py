"""Types of what is read from requests and from the database, learned before there are threads."""

from __future__ import annotations

from collections.abc import Iterable

import msgspec

from annotation_app.studies.study_file import StudyConfig
from annotation_app.tasks.task_registry import tasks
from annotation_app.trying.attempt import Shown
from annotation_app.web.api import REQUESTS
from corpus_tools.corpus.corpus_records import (
    AnnotationRecord,
    CommandRecord,
    ContextRecord,
    JudgmentRecord,
    Manifest,
)
from corpus_tools.logs.channels import CHANNELS


def record_types() -> Iterable[type]:
    """All types that requests may need."""
    of_corpora = (AnnotationRecord, CommandRecord, ContextRecord, JudgmentRecord, Manifest)
    of_logs = (channel.message for channel in CHANNELS.values())
    answers = (task.answer for task in tasks())
    return (StudyConfig, Shown, *of_corpora, *of_logs, *REQUESTS.values(), *answers)


def learn_types() -> None:
    """Have msgspec look at each type now.

    It does so when a type is first used. If two threads do that at the same time, the process may
    die of it (msgspec 0.22). A server that was started again under load did.
    """
    for record_type in record_types():
        msgspec.json.Decoder(record_type)
