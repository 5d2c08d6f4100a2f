"""The task's record."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import msgspec
from flask import Blueprint
from sqlalchemy.orm import Session

from annotation_app.core.problems import FieldProblem
from annotation_app.core.sent_text import clean_text
from annotation_app.items.assignment import AnyItem
from annotation_app.items.item_scenes import watched
from annotation_app.items.new_items import NewItem
from annotation_app.store.models import Answer, Item, Record
from annotation_app.studies.study_file import StudyConfig
from annotation_app.tasks.corpus_parts import add_commands
from annotation_app.tasks.describe import text_problems, typed_often
from annotation_app.tasks.episode_parts import add_wordings
from annotation_app.tasks.task_record import COMMAND, Counts, Source, Task, TaskWords
from annotation_app.tasks.task_registry import register


class Paraphrased(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An answer, as the page sends it."""

    text: str
    played_to_end: bool


@dataclass(frozen=True)
class ParaphraseCounts:
    """Counts for the dashboard."""

    paraphrases: int


def payload(session: Session, item: Item, salt: bytes) -> Record:
    """Return the command and the video for the page."""
    return {"command": item.payload["text"], **watched(session, item)}


def check(
    session: Session, item: AnyItem, answer: Paraphrased, salt: bytes
) -> tuple[Record, list[FieldProblem]]:
    """Return the part of an answer that is kept, and the problems in it."""
    text = clean_text(answer.text)
    problems = [*text_problems(text)]
    if words(text) == words(item.payload["text"]):
        problems.append(FieldProblem("text", "These are the same words. Use others."))
    if not answer.played_to_end:
        problems.append(FieldProblem("played_to_end", "Watch the video to its end first."))
    return {"text": text}, problems


def words(text: str) -> list[str]:
    """Return a command's words, without case and punctuation."""
    return [word.strip(".,;:!?") for word in text.casefold().split()]


def items(session: Session, config: StudyConfig, item: Item, answer: Answer) -> Iterator[NewItem]:
    """Yield an item for a command, not for its author, unless it is a paraphrase itself."""
    if item.task != "paraphrase":
        about = {"text": answer.body["text"], "command": answer.id, "video": item.payload["video"]}
        yield NewItem("paraphrase", f"command {answer.id}", about, author_id=answer.person_id)


def counts(answers: Sequence[tuple[Record, bool]]) -> Any:
    """Count the answers."""
    return ParaphraseCounts(len(answers))


register(
    Task(
        name="paraphrase",
        words=TaskWords(
            title="Paraphrase",
            summary="Say a command in other words.",
            offer="Read short commands and say each in other words.",
            instructions=(
                "Read the command, then watch the video of what it brings about.",
                "Type a command that asks for the same in other words: change the verb, the "
                "order, or how things are described.",
            ),
        ),
        template="paraphrase/paraphrase.html",
        answer=Paraphrased,
        payload=payload,
        check=check,
        blueprint=Blueprint(
            "paraphrase",
            __name__,
            url_prefix="/paraphrase",
            template_folder="templates",
            static_folder="static",
        ),
        example=lambda scene: {"command": scene.command, **scene.watched},
        gives=COMMAND,
        source=Source(COMMAND, items),
        export=lambda parts: add_commands(parts, "paraphrase"),
        episodes=lambda parts: add_wordings(parts, "paraphrase"),
        counts=Counts(ParaphraseCounts, counts, {"paraphrases": "paraphrases"}),
        oddities=typed_often,
    )
)
