"""Rate: people watch a video and say how well a command fits it.

An item's payload is ``{"video": the one shown, "own_video", "text", "command", "right": True, False
or None}``; attention checks are those whose right answer is known. The page sends ``{"rating"}``,
from 1 (strongly disagree) to 5, which is kept. The answers are a corpus's judgments.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import msgspec
from sqlalchemy.orm import Session

from annotation_app.core.languages import N_
from annotation_app.core.problems import FieldProblem
from annotation_app.items.assignment import AnyItem
from annotation_app.items.item_scenes import watched
from annotation_app.items.new_items import NewItem, draws, other_video
from annotation_app.store.models import Answer, Item, Record, Study
from annotation_app.studies.study_file import StudyConfig, restored
from annotation_app.tasks.agreement import choices
from annotation_app.tasks.corpus_parts import answers_of, people_of
from annotation_app.tasks.episode_parts import EpisodeParts
from annotation_app.tasks.task_record import (
    COMMAND,
    VIDEO_KEYS,
    Counts,
    Source,
    Task,
    TaskWords,
)
from annotation_app.tasks.watched_videos import Seconds, Speed, its_video, with_watching
from corpus_tools.world.scenarios.documents import Problem
from g3.annotation import RATINGS, Judgment

VERDICTS = "meta/verdicts.jsonl"
"""File of a copy of a LeRobot dataset with people's ratings of the dataset's own language."""
AGREES, DISAGREES = 4, 2
"""From and up to which rating an attention check was understood."""
FEWEST_RATINGS = 8
"""Smallest number of ratings, all equal, that is odd."""


class Rated(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A person's agreement: 1 strongly disagrees, 5 strongly agrees."""

    rating: Annotated[int, msgspec.Meta(ge=1, le=5)]
    watched_s: Seconds | None = None
    speed: Speed | None = None


@dataclass(frozen=True, slots=True)
class RatingCounts:
    """The number of answers with each rating."""

    ratings: dict[int, int]


def judgments(session: Session, study: Study) -> list[Judgment]:
    """Return the ratings that people have given in a study."""
    people = people_of(session)
    return [
        Judgment(
            id=f"{study.name}-rating-{answer.id:05d}",
            command=item.payload["text"],
            command_video=item.payload["own_video"],
            shown_video=item.payload["video"],
            rating=RATINGS[answer.body["rating"] - 1],
            subject=people[answer.person_id],
            study=study.name,
        )
        for answer, item in answers_of(session, study, "rate")
    ]


def passes(payload: Record, body: Record) -> bool:
    """Check that an attention check has its right answer."""
    rating: int = body["rating"]
    return rating >= AGREES if payload["right"] else rating <= DISAGREES


def _payload(session: Session, item: Item, _salt: bytes) -> Record:
    return {"command": item.payload["text"], **watched(session, item)}


def _check(
    _session: Session, _item: AnyItem, answer: Rated, _salt: bytes
) -> tuple[Record, list[FieldProblem]]:
    return with_watching({"rating": answer.rating}, answer), []


def _items(session: Session, config: StudyConfig, item: Item, answer: Answer) -> Iterable[NewItem]:
    """Yield a command with its own video, and with another one."""
    own, subject = item.payload["video"], f"command {answer.id}"
    other = other_video(session, item.study_id, own, draws(config, subject))
    for video in (own,) if other is None else (own, other):
        about = _about(answer.body["text"], video, own, command=answer.id)
        yield NewItem("rate", f"{subject} video {video}", about, author_id=answer.person_id)


def _facts(session: Session, item: Item, body: Record) -> list[tuple[str, str]]:
    scale = restored(session.get_one(Study, item.study_id).config).scale
    return [("Rating", f"{body['rating']} of {len(scale)}: {scale[body['rating'] - 1]}")]


def _of_study(config: StudyConfig) -> Iterator[NewItem]:
    """Yield attention checks, and pairs to be rated."""
    for known in config.known_commands if config.attention_checks else ():
        for video in (known.video, known.wrong_video):
            about = _about(known.text, video, known.video, right=video == known.video)
            subject = f"known {known.text[:200]} video {video}"
            yield NewItem("rate", subject, about, attention=True)
    for pair in config.pairs:
        subject = f"pair {pair.own_video} {pair.text[:200]} video {pair.video}"
        yield NewItem("rate", subject, _about(pair.text, pair.video, pair.own_video))


def _about(
    text: str, video: str, own: str, *, command: int | None = None, right: bool | None = None
) -> Record:
    return {"text": text, "command": command, "own_video": own, "video": video, "right": right}


def _study_problem(study: StudyConfig) -> Problem | None:
    if study.attention_checks and not study.known_commands:
        return Problem(
            ("attention_checks",), "there are no known commands to check with", "add known_commands"
        )
    if study.pairs and "rate" not in study.tasks:
        return Problem(("pairs",), "the study has no task to rate them in", "add the task rate")
    for i, known in enumerate(study.known_commands):
        if known.video == known.wrong_video:
            return Problem(
                ("known_commands", i, "wrong_video"),
                "the command can't be wrong for the video that it is right for",
                "name another video",
            )
    return None


def _counts(answers: Sequence[tuple[Record, bool]]) -> Any:
    found = Counter(body["rating"] for body, _ in answers)
    return RatingCounts({value: found[value] for value in range(1, 6)})


def _oddities(bodies: Sequence[Record]) -> Iterator[str]:
    ratings = {body["rating"] for body in bodies}
    if len(bodies) >= FEWEST_RATINGS and len(ratings) == 1:
        yield f"always the same rating: {ratings.pop()}, {len(bodies)} times"


def _add_to_episodes(parts: EpisodeParts) -> None:
    """Add the verdicts: people's ratings of the language of a video, shown with that video."""
    from scipy.stats import binomtest  # noqa: PLC0415 - takes a third of a server's start

    ratings: dict[tuple[str, str], list[int]] = defaultdict(list)
    for answer, item in answers_of(parts.session, parts.study, RATE.name):
        about = item.payload
        if about["video"] in parts.videos and about["video"] == about["own_video"]:
            ratings[about["video"], about["text"]].append(answer.body["rating"])
    for (video, text), given in sorted(ratings.items()):
        agree = sum(rating >= AGREES for rating in given)
        interval = binomtest(agree, len(given)).proportion_ci(method="wilson")
        parts.files[VERDICTS].append(
            {
                "episode_index": parts.episode(video),
                "style": parts.videos[video].get("style", "task"),
                "timestamp": parts.number(video, "timestamp"),
                "content": text,
                "ratings": given,
                "agree": agree / len(given),
                "agree_95": [float(interval.low), float(interval.high)],
                "study": parts.study.name,
            }
        )
    parts.counts["verdicts"] = len(ratings)


RATE = Task(
    name="rate",
    words=TaskWords(
        title=N_("Rate"),
        summary=N_("Watch a video and tell how well a command fits it."),
        offer=N_("Watch short videos and tell how well commands fit them."),
        instructions=(
            N_("Read the command, then watch the video to its end."),
            N_("Tell how much you agree with the statement below it. Trust your own judgment."),
            N_("Some commands fit well and some don't fit at all."),
        ),
        keys=((N_("1 to 5"), N_("choose")), *VIDEO_KEYS),
    ),
    template="tasks/rate.html",
    answer=Rated,
    payload=_payload,
    check=_check,
    example=lambda scene: {"command": scene.command, **scene.watched},
    reads=("statement", "scale"),
    watches=its_video,
    practises=("video", "command"),
    source=Source(COMMAND, _items),
    of_study=_of_study,
    study_problem=_study_problem,
    in_random_order=True,
    passes=passes,
    export=lambda parts: parts.judgments.extend(judgments(parts.session, parts.study)),
    episodes=_add_to_episodes,
    counts=Counts(RatingCounts, _counts, {}, "dashboard/rating_counts.html"),
    facts=_facts,
    agreement=(
        choices(lambda bodies: [[body["rating"] for body in bodies]], ("ordinal", "interval")),
    ),
    gist=lambda body: {"rating": body["rating"]},
    verdict=lambda body: int(body["rating"] >= AGREES),
    oddities=_oddities,
)
