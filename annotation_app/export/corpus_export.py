"""Export of the database as a corpus: each task adds the parts that its answers make."""

from __future__ import annotations

from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.store.models import Study
from annotation_app.tasks.corpus_parts import gather
from annotation_app.tasks.task_record import COMMAND
from annotation_app.tasks.task_registry import tasks
from corpus_tools.corpus.corpus_model import Corpus
from g3.errors import FormatError


def find_only_study(session: Session, name: str | None) -> Study:
    """Return the study of a name, or the only one; a FormatError if none or several match."""
    studies = session.scalars(select(Study).order_by(Study.name)).all()
    found = [study for study in studies if name in (None, study.name)]
    if len(found) != 1:
        names = [study.name for study in studies]
        if name:
            raise FormatError.unknown("study", name, names)
        fix = f"name one of {', '.join(names)}" if names else "start one by `ct annotate`"
        raise FormatError("there are several studies" if names else "there is no study", fix=fix)
    return found[0]


def export_corpus(session: Session, study: Study, *, licence: str = "") -> Corpus:
    """Return a study's corpus.

    Every command is there, also those that came late. An annotation is positive if its
    grounding was adopted. Its random one has the labels that most people gave who checked
    it, and none where they disagree, didn't know, or nobody has checked. Without a world it
    has the adopted clauses alone. What a corpus held that was imported is there as it was,
    where nobody has changed it.
    """
    parts = gather(session, study)
    parts.judgments += parts.original.judgments if parts.original else ()
    for task in sorted(tasks(), key=lambda task: task.gives != COMMAND):
        task.export(parts)
    contexts = [world.context for world in parts.worlds.values()]
    if parts.original and not contexts:  # its texts alone
        contexts = list(parts.original.contexts.values())
    contexts += (annotation.context for annotation in parts.annotations)
    return Corpus.build(
        study.name,
        contexts=contexts,
        commands=parts.commands.values(),
        annotations=parts.annotations,
        judgments=parts.judgments,
        outcomes=parts.original.outcomes if parts.original else (),
        source=f"ct annotate, study {study.name}",
        licence=licence,
    )
