"""Mark: people watch an episode and say whether its task was done, how well, and what went wrong.

An item's payload is ``{"video"}``. The page sends ``{"success", "quality", "reasons", "moment_s",
"note", "watched_s", "speed"}``, which is kept. ``success`` is ``success``, ``partly`` or
``failure``, by which answers are adopted; ``quality`` is from 1 to 5; ``reasons`` are some of the
study's.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from statistics import median
from typing import IO, Annotated, Any, Literal

import msgspec
from sqlalchemy.orm import Session

from annotation_app.core.languages import N_, gettext
from annotation_app.core.problems import FieldProblem
from annotation_app.core.sent_text import clean_text
from annotation_app.items.assignment import AnyItem
from annotation_app.items.item_scenes import film_of, watched
from annotation_app.store.models import Answer, Item, Record, Study
from annotation_app.studies.study_file import MOST_REASONS, restored
from annotation_app.tasks.agreement import choices
from annotation_app.tasks.corpus_parts import answers_of
from annotation_app.tasks.episode_parts import EpisodeParts, KeepFrom
from annotation_app.tasks.task_record import (
    VIDEO_KEYS,
    Adjudication,
    AnswerTable,
    Compared,
    Counts,
    Task,
    TaskWords,
    write_csv,
)
from annotation_app.tasks.watched_videos import (
    Seconds,
    Speed,
    item_of_video,
    its_video,
    opened_with,
    with_watching,
)
from corpus_tools.lerobot.episode_index import IndexColumn, Kind

SUCCESSES = ("success", "partly", "failure")
"""From the best to the worst."""
MARKS = "meta/marks.jsonl"
TO_DELETE = "meta/delete_episodes.json"
"""File of a copy of a LeRobot dataset: a configuration of ``lerobot-edit-dataset``."""
MARKS_OF = ("success", "quality", "reasons", "moment_s", "note")
"""Fields of an answer."""
LONGEST_NOTE = 2000
SLACK_S = 0.5
"""Largest time beyond a video's end at which it may fail, as players round, in seconds."""


class Marked(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A person's marks for an episode."""

    success: Literal["success", "partly", "failure"]
    quality: Annotated[int, msgspec.Meta(ge=1, le=5)]
    reasons: Annotated[tuple[str, ...], msgspec.Meta(max_length=MOST_REASONS)] = ()
    moment_s: Seconds | None = None
    """Time in the video at which it fails."""
    note: str = ""
    watched_s: Seconds | None = None
    speed: Speed | None = None


@dataclass(frozen=True, slots=True)
class MarkCounts:
    """Counts of marks."""

    marks: int
    mark_success: dict[str, int]
    mark_quality: dict[int, int]
    mark_reasons: dict[str, int]


@dataclass(frozen=True, slots=True)
class EpisodeMarks:
    """Several people's marks of an episode, taken together."""

    success: str | None
    """The adopted one; None before an answer is adopted."""
    quality: float
    """Median."""
    reasons: list[str]
    """Those of at least half of the people who agree with `success`, most frequent first."""
    moment_s: float | None
    """Median of theirs."""
    people: int
    agree: float
    """Share of the people with the adopted success, or with the most frequent one."""

    def is_below(self, least: KeepFrom) -> bool:
        """Return True if the episode isn't to be kept. Undecided ones are."""
        too_bad = SUCCESSES.index(self.success or "success") > SUCCESSES.index(least.success)
        return self.success is not None and (too_bad or self.quality < least.quality)


COLUMNS: dict[str, Kind] = {
    "success": "text",
    "quality": "number",
    "reasons": "texts",
    "moment_s": "number",
    "people": "count",
    "agree": "number",
}
"""The fields of :class:`EpisodeMarks` as columns ``marks/…`` of the episodes' index."""


def marks_of(answers: Sequence[Answer]) -> EpisodeMarks:
    """Take the answers about an episode together; an adjudicator's own decides alone."""
    usual = [one for one in answers if one.kind != "adjudicated"] or answers
    adopted = next((one for one in answers if one.adopted), None)
    votes = Counter(one.body["success"] for one in usual)
    success = adopted.body["success"] if adopted is not None else None
    asked = [adopted] if adopted is not None and adopted.kind == "adjudicated" else usual
    alike = [one for one in asked if success in (None, one.body["success"])]
    reasons = Counter(reason for one in alike for reason in one.body["reasons"])
    moments = [one.body["moment_s"] for one in alike if one.body["moment_s"] is not None]
    return EpisodeMarks(
        success,
        float(median(one.body["quality"] for one in asked)),
        [reason for reason, count in reasons.most_common() if 2 * count >= len(alike)],
        float(median(moments)) if moments else None,
        len(usual),
        (votes[success] if success else max(votes.values())) / len(usual),
    )


def _payload(session: Session, item: Item, _salt: bytes) -> Record:
    """Return the video, and the dataset's task, if the study's table has one."""
    film = film_of(session, item.study_id, item.payload["video"])
    task = film.metadata.get("task", "") if film is not None else ""
    return {"command": str(task), **watched(session, item)}


def _check(
    session: Session, item: AnyItem, answer: Marked, _salt: bytes
) -> tuple[Record, list[FieldProblem]]:
    body = {
        "success": answer.success,
        "quality": answer.quality,
        "reasons": list(dict.fromkeys(answer.reasons)),
        "moment_s": answer.moment_s,
        "note": clean_text(answer.note),
    }
    return with_watching(body, answer), list(_problems(session, item, body))


def _problems(session: Session, item: AnyItem, body: Record) -> Iterator[FieldProblem]:
    config = restored(session.get_one(Study, item.study_id).config)
    if not set(body["reasons"]) <= set(config.reasons):
        yield FieldProblem("reasons", gettext("The reasons have changed. Load the page again."))
    duration_s = float(watched(session, item)["duration_s"])
    if (body["moment_s"] or 0) > duration_s + SLACK_S:
        yield FieldProblem("moment_s", gettext("The moment is after the video’s end."))
    if len(body["note"]) > LONGEST_NOTE:
        most = gettext("Use at most %(most)s characters for the note.", most=LONGEST_NOTE)
        yield FieldProblem("note", most)


def _counts(answers: Sequence[tuple[Record, bool]]) -> Any:
    success = Counter(body["success"] for body, _ in answers)
    quality = Counter(body["quality"] for body, _ in answers)
    reasons = Counter(reason for body, _ in answers for reason in body["reasons"])
    return MarkCounts(
        len(answers),
        {name: success[name] for name in SUCCESSES},
        {value: quality[value] for value in range(1, 6)},
        dict(reasons.most_common()),
    )


def _facts(_session: Session, _item: Item, body: Record) -> list[tuple[str, str]]:
    facts = [("Success", body["success"]), ("Quality", f"{body['quality']} of 5")]
    facts += [("Reason", reason) for reason in body["reasons"]]
    if body["moment_s"] is not None:
        facts.append(("Fails at", f"{body['moment_s']:.1f} s"))
    return [*facts, ("Note", body["note"])] if body["note"] else facts


def _compare(session: Session, item: Item, bodies: Sequence[Record], _salt: bytes) -> Compared:
    return Compared(tuple(_facts(session, item, body) for body in bodies))


def _add_to_episodes(parts: EpisodeParts) -> None:
    """Add marks as columns of the episodes' index, one by one, and the episodes to delete."""
    by_episode: dict[int, list[Answer]] = defaultdict(list)
    for answer, item in answers_of(parts.session, parts.study, MARK.name):
        if parts.shows_whole_episode(item.payload["video"]):
            by_episode[parts.episode(item.payload["video"])].append(answer)
    if not by_episode:
        return
    marks = {index: marks_of(answers) for index, answers in sorted(by_episode.items())}
    parts.columns += [
        IndexColumn(f"marks/{name}", kind, {i: getattr(one, name) for i, one in marks.items()})
        for name, kind in COLUMNS.items()
    ]
    for index, one in marks.items():
        answers = by_episode[index]
        given = [
            parts.source(answer, kind=answer.kind, **{name: answer.body[name] for name in MARKS_OF})
            for answer in answers
        ]
        parts.files[MARKS].append(
            {"episode_index": index, **{n: getattr(one, n) for n in COLUMNS}, "given": given}
        )
    bad = [index for index, one in marks.items() if one.is_below(parts.keep_from)]
    if bad:
        operation = {"type": "delete_episodes", "episode_indices": bad}
        parts.documents[TO_DELETE] = {"operation": operation}
    parts.counts |= {"marked": len(marks), "to delete": len(bad)}


def _table(session: Session, study: Study, file: IO[bytes]) -> None:
    """Write a row for each marked video."""
    by_video: dict[str, list[Answer]] = defaultdict(list)
    for answer, item in answers_of(session, study, MARK.name):
        by_video[item.payload["video"]].append(answer)
    rows = []
    for video, answers in sorted(by_video.items()):
        one = marks_of(answers)
        values = {name: getattr(one, name) for name in COLUMNS}
        notes = " | ".join(answer.body["note"] for answer in answers if answer.body["note"])
        rows.append((video, *(values | {"reasons": "; ".join(one.reasons)}).values(), notes))
    write_csv(file, ("video", *COLUMNS, "notes"), rows)


MARK = Task(
    name="mark",
    words=TaskWords(
        title=N_("Mark"),
        summary=N_("Watch a video and tell whether the robot did its task, and how well."),
        offer=N_("Watch short videos of a robot and tell whether it did its task, and how well."),
        instructions=(
            N_(
                "Watch the video to its end, and tell whether the robot did its task. “Partly” "
                "means a part of it, or only after a mistake."
            ),
            N_(
                "Tell how well it did it: 5 if somebody could learn it from this video, 1 if "
                "nobody should."
            ),
            N_(
                "If something went wrong, choose the reasons. Then go to the moment where it goes "
                "wrong, and press “It fails here”."
            ),
        ),
        keys=(
            ("S P F", N_("success, partly, failure")),
            (N_("1 to 5"), N_("choose how well")),
            ("A B C …", N_("choose a reason, or not")),
            ("M", N_("it fails here")),
            *VIDEO_KEYS,
        ),
    ),
    template="tasks/mark.html",
    answer=Marked,
    payload=_payload,
    check=_check,
    example=lambda scene: {"command": scene.command, **scene.watched},
    reads=("reasons",),
    watches=its_video,
    practises=("video",),
    of_video=item_of_video("mark"),
    adjudication=Adjudication(
        essence=lambda body: body["success"],
        agreement=lambda one, other: float(one["success"] == other["success"]),
        compare=_compare,
        opened=opened_with,
        template="dashboard/compare_facts.html",
    ),
    episodes=_add_to_episodes,
    counts=Counts(MarkCounts, _counts, {"marks": "marks"}, "dashboard/mark_counts.html"),
    agreement=(
        choices(lambda bodies: [[b["success"] for b in bodies]], of="success", with_share=True),
        choices(
            lambda bodies: [[b["quality"] for b in bodies]],
            ("ordinal", "interval"),
            of="quality",
            with_share=True,
        ),
    ),
    gist=lambda body: {name: body[name] for name in ("success", "quality", "reasons")},
    facts=_facts,
    tables={
        "marks.csv": AnswerTable(
            "Marks by video (CSV)", "text/csv", _table, "success, quality and reasons of each video"
        )
    },
)
