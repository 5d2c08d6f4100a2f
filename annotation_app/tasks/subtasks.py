"""Subtasks: people watch an episode and say which subtasks it is made of, one after the other.

An item's payload is ``{"video"}`` and, where a model has proposed subtasks, what
:mod:`.proposed_steps` says. The page sends ``{"subtasks": [{"start_s", "text"}], "decided",
"played_to_end", "watched_s", "speed"}``. The first subtask begins with the video, and each lasts
until the next one begins; ``decided`` numbers the proposed steps that were accepted. An answer is
adopted at once; with several answers to an episode, that which agrees best with the others is
exported (:func:`most_agreed`).
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any

import msgspec
import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.core.languages import N_, gettext
from annotation_app.core.problems import FieldProblem
from annotation_app.core.sent_text import clean_text
from annotation_app.items.assignment import AnyItem
from annotation_app.items.item_scenes import watched
from annotation_app.store.models import Answer, Item, Record, Study, TaskName
from annotation_app.studies.study_file import StudyConfig, restored
from annotation_app.tasks.agreement import CLOSE_S, mean_of_pairs, times_f
from annotation_app.tasks.corpus_parts import answers_of
from annotation_app.tasks.episode_parts import EpisodeParts
from annotation_app.tasks.model_errors import TABLES, model_errors
from annotation_app.tasks.proposed_steps import step_fates, step_likeness, suggested_steps
from annotation_app.tasks.step_alignment import (
    Step,
    steps_from,
    text_agreement,
    time_agreement,
)
from annotation_app.tasks.task_record import EDITOR_KEYS, Counts, Task, TaskWords
from annotation_app.tasks.watched_videos import (
    Seconds,
    Speed,
    item_of_video,
    its_video,
    video_payload,
    with_watching,
)
from corpus_tools.episodes.step_errors import ADDED
from corpus_tools.lerobot.language_rows import PLAN, SUBTASK, Language
from corpus_tools.world.scenarios.documents import Problem

LONGEST_TEXT = 300
MOST_SUBTASKS = 200
SLACK_S = 0.5
"""Largest time beyond a video's end at which a subtask may begin, as players round, in seconds."""


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


class Subtask(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An activity that begins at a time."""

    start_s: Seconds
    text: str


class CutUp(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The subtasks of an episode in their order."""

    subtasks: Annotated[list[Subtask], msgspec.Meta(max_length=MOST_SUBTASKS)]
    decided: Annotated[
        list[Annotated[int, msgspec.Meta(ge=0)]], msgspec.Meta(max_length=MOST_SUBTASKS)
    ] = []
    played_to_end: bool = True
    watched_s: Seconds = 0.0
    speed: Speed | None = None


@dataclass(frozen=True, slots=True)
class SubtaskCounts:
    """Counts of subtasks."""

    subtasks: int
    episodes_cut: int


def boundary_f(one: Record, other: Record) -> float:
    """Return the F score of the subtasks' beginnings, without the first, which is the video's."""
    mine, theirs = ([s["start_s"] for s in body["subtasks"][1:]] for body in (one, other))
    return times_f(mine, theirs)


def steps_of(body: Record) -> list[tuple[float, str]]:
    """Return the beginning of each subtask of an answer, in seconds, and its description."""
    return [(float(step["start_s"]), step["text"]) for step in body["subtasks"]]


def most_agreed(bodies: Sequence[Record]) -> int:
    """Return the index of the answer that agrees best with the others; the first if several do."""
    scores = [
        sum(boundary_f(body, other) for other in bodies if other is not body) for body in bodies
    ]
    return int(np.argmax(scores))


def _check(
    session: Session, item: AnyItem, answer: CutUp, _salt: bytes
) -> tuple[Record, list[FieldProblem]]:
    config = restored(session.get_one(Study, item.study_id).config)
    listed = listed_steps(config)
    subtasks = []
    for step in answer.subtasks:
        text = clean_text(step.text)
        subtasks.append({"start_s": step.start_s, "text": listed.get(step_key(text), text)})
    duration_s = float(watched(session, item)["duration_s"])
    problems = list(_problems(subtasks, duration_s))
    if is_closed(config):
        problems += _unlisted(subtasks, listed)
    body: Record = {"subtasks": subtasks, "duration_s": duration_s}
    if answer.decided:
        body["decided"] = sorted(set(answer.decided))
    return with_watching(body, answer), problems


def _unlisted(subtasks: Sequence[Record], listed: Mapping[str, str]) -> Iterator[FieldProblem]:
    for number, subtask in enumerate(subtasks, start=1):
        if step_key(subtask["text"]) not in listed:
            message = gettext("Choose step %(number)s from the list.", number=number)
            yield FieldProblem(f"subtasks[{number - 1}]", message)


def _problems(subtasks: Sequence[Record], duration_s: float) -> Iterator[FieldProblem]:
    if not subtasks:
        yield FieldProblem("subtasks", gettext("Name at least one step."))
        return
    if subtasks[0]["start_s"] != 0:
        yield FieldProblem("subtasks[0]", gettext("The first step begins with the video."))
    for number, subtask in enumerate(subtasks, start=1):
        where = f"subtasks[{number - 1}]"
        if not any(character.isalnum() for character in subtask["text"]):
            yield FieldProblem(
                where, gettext("Say what is done in step %(number)s.", number=number)
            )
        elif len(subtask["text"]) > LONGEST_TEXT:
            yield FieldProblem(
                where, gettext("Use at most %(most)s characters for a step.", most=LONGEST_TEXT)
            )
        if subtask["start_s"] > duration_s + SLACK_S:
            yield FieldProblem(
                where, gettext("Step %(number)s begins after the video's end.", number=number)
            )
    for number, (one, following) in enumerate(pairwise(subtasks), start=2):
        if following["start_s"] <= one["start_s"]:
            message = gettext("Step %(number)s must begin after the one before it.", number=number)
            yield FieldProblem(f"subtasks[{number - 1}]", message)


def _counts(answers: Sequence[tuple[Record, bool]]) -> Any:
    return SubtaskCounts(sum(len(body["subtasks"]) for body, _ in answers), len(answers))


def _mean_likeness(one: Sequence[Step], other: Sequence[Step]) -> float | None:
    texts = text_agreement(one, other)
    return float(np.mean(texts)) if texts else None


def _cut_of(body: Record) -> list[Step]:
    steps = steps_of(body)
    # Answers from before have no duration: their last step lasts as long as was watched.
    return steps_from(steps, float(body.get("duration_s") or body.get("watched_s") or 0.0))


def _add_to_episodes(parts: EpisodeParts) -> None:
    """Add the subtasks of each episode: of several answers, that which agrees best."""
    by_episode = defaultdict(list)
    for answer, item in answers_of(parts.session, parts.study, SUBTASKS.name):
        if parts.shows_whole_episode(item.payload["video"]):
            by_episode[parts.episode(item.payload["video"])].append(answer)
    for index, answers in by_episode.items():
        chosen = answers[most_agreed([answer.body for answer in answers])]
        scores = [boundary_f(chosen.body, a.body) for a in answers if a is not chosen]
        agreement = sum(scores) / len(scores) if scores else None
        source = parts.source(chosen, answers=len(answers), agreement=agreement)
        fates = _fates_by_step(chosen)
        parts.language[index] += [
            Language(SUBTASK, time, text, source | fates.get(number, {}))
            for number, (time, text) in enumerate(steps_of(chosen.body))
        ]
        parts.replaced[index] |= {SUBTASK, PLAN}
    parts.counts["steps"] = sum(
        row.style == SUBTASK for rows in parts.language.values() for row in rows
    )


def _fates_by_step(answer: Answer) -> dict[int, Record]:
    """Return for each step of an answer the model that proposed it, and what the person changed."""
    provenance = answer.provenance or {}
    fates = provenance.get("fates")
    if fates is None:
        return {}
    about = {"model": fates["source"], "proposal": provenance["suggestion"]}
    states = {step["step"]: step["state"] for step in fates["steps"]}
    return {
        number: about | {"became": states.get(number, ADDED)}
        for number in range(len(answer.body["subtasks"]))
    }


def _payload(session: Session, item: Item, salt: bytes) -> Record:
    listed = page_vocabulary(session, item.study_id, SUBTASKS.name)
    return video_payload(session, item, salt) | {"vocabulary": listed}


def _study_problem(study: StudyConfig) -> Problem | None:
    for name in ("subtasks", "vocabulary", "vocabulary_grows"):
        if getattr(study, name) and SUBTASKS.name not in study.tasks:
            what = "the study has no task in which people see it"
            return Problem((name,), what, "add the task subtasks, or leave it out")
    return None


SUBTASKS = Task(
    name="subtasks",
    words=TaskWords(
        title=N_("Subtasks"),
        summary=N_("Watch a video and tell which steps it is made of."),
        offer=N_("Watch short videos and name the steps in them."),
        instructions=(
            N_("Watch the video to its end. You may watch it again as often as you like."),
            N_("Type what the robot does first. Begin with a verb: “Pick up the cup”."),
            N_(
                "Go to the moment at which the next step begins, press “A step begins here”, and "
                "type what is done from then on."
            ),
            N_(
                "A step ends when the next one begins. Begin a new one when the robot takes hold "
                "of something, lets it go, or turns to something else."
            ),
            N_(
                "If steps are proposed, accept each that is right. Else correct its text, move its "
                "beginning on the timeline, or remove it."
            ),
        ),
        keys=(
            ("N", N_("a step begins here, also within another one")),
            ("B", N_("the nearest beginning comes here")),
            ("M", N_("merge this step with the next")),
            ("A", N_("accept this step")),
            ("X", N_("remove this step")),
            ("E", N_("change this step's text")),
            ("[ ]", N_("go from step to step")),
            ("← →", N_("at a beginning on the timeline: a frame back, or on")),
            (N_("Shift ← →"), N_("the same: a second back, or on")),
            ("+ -", N_("show a shorter, or longer, part of the timeline")),
            *EDITOR_KEYS,
        ),
    ),
    template="tasks/subtasks.html",
    answer=CutUp,
    payload=_payload,
    check=_check,
    example=lambda scene: scene.watched,
    suggestion=suggested_steps,
    shown_suggestion=lambda _session, _item, suggestion, _salt: suggestion["steps"],
    likeness=step_likeness,
    fates=step_fates,
    suggests_in_english=False,
    reads=("subtasks", "vocabulary", "vocabulary_grows"),
    hides_title=True,
    watches=its_video,
    practises=("video",),
    of_video=item_of_video("subtasks"),
    study_problem=_study_problem,
    model_errors=model_errors,
    tables=TABLES,
    counts=Counts(SubtaskCounts, _counts, {"subtasks": "subtasks"}),
    facts=lambda _session, _item, body: [(f"{s:.1f} s", text) for s, text in steps_of(body)],
    agreement=(
        mean_of_pairs({f"beginnings within {CLOSE_S:g} s, F": boundary_f}),
        mean_of_pairs(
            {
                "time in the same step, share": time_agreement,
                "texts of steps that overlap by half, likeness": _mean_likeness,
            },
            _cut_of,
        ),
    ),
    episodes=_add_to_episodes,
)
