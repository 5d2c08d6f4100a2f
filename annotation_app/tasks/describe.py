"""Describe: people watch a video and type the command that it fulfils.

An item's payload is ``{"video"}``. The page sends ``{"text", "played_to_end", "watched_s",
"speed"}``; all but the second, by which the page itself knows, are kept. An answer is a command at
once.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import msgspec
from sqlalchemy.orm import Session

from annotation_app.core.languages import N_, gettext
from annotation_app.core.problems import FieldProblem
from annotation_app.core.sent_text import clean_text
from annotation_app.items.assignment import AnyItem
from annotation_app.store.models import Record
from annotation_app.tasks.corpus_parts import add_commands
from annotation_app.tasks.episode_parts import add_wordings
from annotation_app.tasks.task_record import COMMAND, VIDEO_KEYS, Counts, Task, TaskWords
from annotation_app.tasks.watched_videos import (
    Seconds,
    Speed,
    item_of_video,
    its_video,
    video_payload,
    with_watching,
)

LONGEST_TEXT = 2000
LONGEST_COMMAND_WORDS = 200
SAME_TEXTS = 3
"""Number of equal texts by one person that is odd."""


class Described(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A command for what a video shows."""

    text: str
    played_to_end: bool = True
    watched_s: Seconds = 0.0
    speed: Speed | None = None


@dataclass(frozen=True, slots=True)
class CommandCounts:
    """Counts of commands."""

    commands: int
    words: int
    vocabulary: int


def text_problems(text: str) -> Iterator[FieldProblem]:
    """Yield the faults of a command that a person has typed."""
    if not any(character.isalnum() for character in text):
        yield FieldProblem("text", gettext("Type a command."))
    elif len(text) > LONGEST_TEXT:
        told = gettext("This is %(long)s characters long. Use at most %(most)s.")
        yield FieldProblem("text", told % {"long": len(text), "most": LONGEST_TEXT})
    elif len(text.split()) > LONGEST_COMMAND_WORDS:
        yield FieldProblem(
            "text",
            gettext("Use at most %(most)s words for the command.", most=LONGEST_COMMAND_WORDS),
        )


def typed_often(bodies: Sequence[Record]) -> Iterator[str]:
    """Yield a remark if a person has typed the same command again and again."""
    texts = Counter(body["text"].casefold() for body in bodies)
    same = max(texts.values(), default=0)
    if same >= SAME_TEXTS:
        yield f"typed the same command {same} times"


def _check(
    _session: Session, _item: AnyItem, answer: Described, _salt: bytes
) -> tuple[Record, list[FieldProblem]]:
    text = clean_text(answer.text)
    return with_watching({"text": text}, answer), [*text_problems(text)]


def _counts(answers: Sequence[tuple[Record, bool]]) -> Any:
    texts = [body["text"].split() for body, _ in answers]
    different = {word.casefold().strip(".,;:!?") for text in texts for word in text}
    return CommandCounts(len(texts), sum(map(len, texts)), len(different))


DESCRIBE = Task(
    name="describe",
    words=TaskWords(
        title=N_("Describe"),
        summary=N_("Watch a video and type the command that it fulfils."),
        offer=N_("Watch short videos and type a command for each."),
        instructions=(
            N_("Watch the video to its end. You may watch it again as often as you like."),
            N_(
                "Imagine that you had told an expert operator to do exactly this. Type the command "
                "that you would have given, in your own words, in English."
            ),
            N_(
                "Say what is to be done, not what you see: the operator hears you before anything "
                "has happened, and sees the same scene."
            ),
            N_("Write as you would speak. There is no single right answer."),
        ),
        keys=VIDEO_KEYS,
        prompt=N_("Type the command you would give an expert operator"),
    ),
    template="tasks/describe.html",
    answer=Described,
    payload=video_payload,
    check=_check,
    example=lambda scene: scene.watched,
    hides_title=True,
    watches=its_video,
    practises=("video",),
    gives=COMMAND,
    of_video=item_of_video("describe"),
    export=lambda parts: add_commands(parts, "describe"),
    episodes=lambda parts: add_wordings(parts, "describe"),
    counts=Counts(
        CommandCounts,
        _counts,
        {"commands": "commands", "words": "words", "vocabulary": "different words"},
    ),
    oddities=typed_often,
)
