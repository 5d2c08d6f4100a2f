"""Correct: people watch an episode and say whether its task is right; if not, they write it.

An item is about a command that the study's table gives, and its payload is ``{"video", "text",
"command"}``. The page sends ``{"verdict", "text", "watched_s", "speed"}``, which is kept: the
verdict is ``right``, ``wrong`` or ``unclear``, and only with ``wrong`` there is a text. Answers are
alike if they have the same verdict, and texts with the same words.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import msgspec
from sqlalchemy.orm import Session

from annotation_app.core.languages import N_, gettext
from annotation_app.core.problems import FieldProblem
from annotation_app.core.sent_text import clean_text
from annotation_app.items.assignment import AnyItem
from annotation_app.items.item_scenes import film_of, watched
from annotation_app.items.new_items import GIVEN, NewItem
from annotation_app.store.models import Answer, Item, Record
from annotation_app.studies.study_file import StudyConfig
from annotation_app.tasks.agreement import Agreement, Measured, choices, share_alike
from annotation_app.tasks.corpus_parts import answers_of
from annotation_app.tasks.describe import LONGEST_TEXT
from annotation_app.tasks.episode_parts import EpisodeParts
from annotation_app.tasks.task_record import (
    COMMAND,
    VIDEO_KEYS,
    Adjudication,
    Compared,
    Counts,
    Source,
    Task,
    TaskWords,
)
from annotation_app.tasks.watched_videos import (
    Seconds,
    Speed,
    its_video,
    opened_with,
    with_watching,
)

VERDICTS = ("right", "wrong", "unclear")
CORRECTIONS = "meta/task_corrections.jsonl"
"""File of a copy of a LeRobot dataset: tasks, what people say of them, and the new ones."""


class Corrected(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A person's verdict on a task."""

    verdict: Literal["right", "wrong", "unclear"]
    text: str = ""
    """Right text of a wrong task."""
    watched_s: Seconds | None = None
    speed: Speed | None = None


@dataclass(frozen=True, slots=True)
class CorrectionCounts:
    """Counts of verdicts, and of tasks with an adopted new text."""

    task_verdicts: dict[str, int]
    tasks_corrected: int


def words_of(text: str) -> str:
    """Return the words of a text in small letters, which texts that are alike share."""
    return " ".join(re.findall(r"\w+", text.casefold()))


def _essence(body: Record) -> tuple[str, str]:
    return body["verdict"], words_of(body["text"])


def _payload(session: Session, item: Item, _salt: bytes) -> Record:
    return {"command": item.payload["text"], **watched(session, item)}


def _check(
    _session: Session, item: AnyItem, answer: Corrected, _salt: bytes
) -> tuple[Record, list[FieldProblem]]:
    text = clean_text(answer.text) if answer.verdict == "wrong" else ""
    body = {"verdict": answer.verdict, "text": text}
    is_wrong = answer.verdict == "wrong"
    return with_watching(body, answer), [*_problems(item, text)] if is_wrong else []


def _problems(item: AnyItem, text: str) -> Iterator[FieldProblem]:
    if not words_of(text):
        yield FieldProblem("text", gettext("Type what the task should be."))
    elif words_of(text) == words_of(item.payload["text"]):
        yield FieldProblem("text", gettext("This is the same task. Change it, or choose “Right”."))
    elif len(text) > LONGEST_TEXT:
        told = gettext("This is %(long)s characters long. Use at most %(most)s.")
        yield FieldProblem("text", told % {"long": len(text), "most": LONGEST_TEXT})


def _items(session: Session, _config: StudyConfig, item: Item, answer: Answer) -> Iterable[NewItem]:
    """Yield the item about a command that a table gave; people's own need no correction.

    A dataset's texts about parts of episodes aren't their tasks.
    """
    video = item.payload["video"]
    film = film_of(session, item.study_id, video)
    if item.subject.startswith(GIVEN) and (film is None or "style" not in film.metadata):
        about = {"text": answer.body["text"], "command": answer.id, "video": video}
        yield NewItem("correct", f"command {answer.id}", about)


def _counts(answers: Sequence[tuple[Record, bool]]) -> Any:
    found = Counter(body["verdict"] for body, _ in answers)
    corrected = sum(adopted and body["verdict"] == "wrong" for body, adopted in answers)
    return CorrectionCounts({name: found[name] for name in VERDICTS}, corrected)


def _new_texts(bodies: Sequence[Record]) -> list[list[str]]:
    return [[words_of(body["text"]) for body in bodies if body["verdict"] == "wrong"]]


def _alike(texts: Sequence[Sequence[str]]) -> list[Measured]:
    """Return the share of new texts that agree, if people have written several for a task."""
    found = share_alike(texts, "new text: share of pairs that agree")
    return [found] if found.units else []


def _facts(_session: Session, _item: Item, body: Record) -> list[tuple[str, str]]:
    verdict = [("Task", body["verdict"])]
    return [*verdict, ("New text", body["text"])] if body["text"] else verdict


def _compare(session: Session, item: Item, bodies: Sequence[Record], _salt: bytes) -> Compared:
    return Compared(tuple(_facts(session, item, body) for body in bodies))


def _add_to_episodes(parts: EpisodeParts) -> None:
    """Add the new texts that were adopted, and all verdicts with their sources."""
    by_item: dict[str, tuple[Item, list[Answer]]] = {}
    for answer, item in answers_of(parts.session, parts.study, CORRECT.name):
        if parts.shows_whole_episode(item.payload["video"]):
            by_item.setdefault(item.id, (item, []))[1].append(answer)
    if not by_item:
        return
    corrected = 0
    for item, answers in by_item.values():
        index, old = parts.episode(item.payload["video"]), item.payload["text"]
        adopted = next((one for one in answers if one.adopted), None)
        decision = None if adopted is None else adopted.body["verdict"]
        if adopted is not None and decision == "wrong":
            parts.corrected[index][old] = adopted.body["text"]
            corrected += 1
        usual = [one.body for one in answers if one.kind != "adjudicated"]
        essence = None if adopted is None else _essence(adopted.body)
        votes = Counter(body["verdict"] for body in usual)
        parts.files[CORRECTIONS].append(
            {
                "episode_index": index,
                "task_was": old,
                "task": adopted.body["text"]
                if adopted is not None and decision == "wrong"
                else old,
                "decision": decision,
                "votes": {name: votes[name] for name in VERDICTS},
                "agree": sum(_essence(b) == essence for b in usual) / len(usual) if usual else None,
                "given": [
                    parts.source(
                        one, kind=one.kind, verdict=one.body["verdict"], text=one.body["text"]
                    )
                    for one in answers
                ],
            }
        )
    parts.files[CORRECTIONS].sort(key=lambda row: row["episode_index"])
    parts.counts |= {"tasks judged": len(by_item), "corrected": corrected}


def _agreement(one: Record, other: Record) -> float:
    return float(_essence(one) == _essence(other))


CORRECT = Task(
    name="correct",
    words=TaskWords(
        title=N_("Correct"),
        summary=N_("Watch a video and tell whether a task is the one that the robot does."),
        offer=N_("Watch short videos and correct the tasks that don’t fit."),
        instructions=(
            N_("Read the task, then watch the video to its end."),
            N_(
                "“Right”: the robot does this task, or tries to. “I can’t tell”: the video or the "
                "text doesn’t say enough."
            ),
            N_(
                "“Wrong”: it does something else. Change the text so that it says what the robot "
                "does, such as “Put the cup on the plate”."
            ),
        ),
        keys=(
            ("R W U", N_("right, wrong, I can’t tell")),
            *VIDEO_KEYS,
        ),
        prompt=N_("What should the task be?"),
    ),
    template="tasks/correct.html",
    answer=Corrected,
    payload=_payload,
    check=_check,
    example=lambda scene: {"command": scene.command, **scene.watched},
    watches=its_video,
    practises=("video", "command"),
    source=Source(COMMAND, _items),
    in_random_order=True,
    adjudication=Adjudication(
        essence=_essence,
        agreement=_agreement,
        compare=_compare,
        opened=opened_with,
        template="dashboard/compare_facts.html",
    ),
    episodes=_add_to_episodes,
    counts=Counts(
        CorrectionCounts,
        _counts,
        {"tasks_corrected": "tasks corrected"},
        "dashboard/correction_counts.html",
    ),
    agreement=(
        choices(lambda bodies: [[b["verdict"] for b in bodies]], of="verdict", with_share=True),
        Agreement(_new_texts, _alike),
    ),
    facts=_facts,
)
