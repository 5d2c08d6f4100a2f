"""Moments: people write texts at moments of an episode, in the styles that a study asks for.

The styles are those of LeRobot's language format that are neither a wording of the task
(*Describe*) nor a subtask (*Subtasks*): see :mod:`corpus_tools.lerobot.language_rows`.

An item's payload is ``{"video"}``. The page sends ``{"moments": [{"style", "time_s", "text",
"reply", "answer": {"kind", "texts", "shapes": [{"points", "label"}]}}], "played_to_end",
"watched_s", "speed"}``; shapes are in pixels of the picture. An answer is adopted at once. All
people's events are exported, and of texts that hold from a time on the answer that agrees best
with the others.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, TypeAlias

import msgspec
from sqlalchemy.orm import Session

from annotation_app.core.languages import N_, gettext
from annotation_app.core.problems import FieldProblem
from annotation_app.core.sent_text import clean_text
from annotation_app.items.assignment import AnyItem
from annotation_app.items.item_scenes import film_of_item
from annotation_app.items.scenes import Film
from annotation_app.store.models import Answer, Item, Record, Study
from annotation_app.studies.study_file import TaskConfig, restored
from annotation_app.tasks.agreement import CLOSE_S, matched_times, mean_of_pairs
from annotation_app.tasks.corpus_parts import answers_of
from annotation_app.tasks.drawn_answers import Coordinate
from annotation_app.tasks.episode_parts import EpisodeParts
from annotation_app.tasks.task_record import (
    VIDEO_KEYS,
    Counts,
    StyleWords,
    Task,
    TaskWords,
    asked_styles,
)
from annotation_app.tasks.watched_videos import (
    Seconds,
    Speed,
    item_of_video,
    its_video,
    video_payload,
    with_watching,
)
from corpus_tools.lerobot.grounded_answers import PATH, Fault, Shape
from corpus_tools.lerobot.grounded_answers import Answer as GroundedAnswer
from corpus_tools.lerobot.language_rows import (
    INTERJECTION,
    MEMORY,
    MOTION,
    PLAN,
    STYLES,
    TRACE,
    VQA,
    Language,
)

LONGEST_TEXT = 500
MOST_MOMENTS = 200
MOST_POINTS = 1000
SLACK_S = 0.5
"""Largest time beyond a video's end of a moment, as players round, in seconds."""

FAULTS = {
    Fault.TEXT: N_("Type a text at number %(number)s."),
    Fault.ANSWER: N_("Answer the question at number %(number)s."),
    Fault.NUMBER: N_("Type how many as a whole number at number %(number)s."),
    Fault.DRAWING: N_("Draw in the picture at number %(number)s."),
    Fault.LABEL: N_("Name each box at number %(number)s."),
    Fault.OUTSIDE: N_("What is drawn at number %(number)s is outside of the picture."),
}
"""Messages for people about broken rules."""
OTHER_FAULT = N_("Number %(number)s doesn't fit here. Load the page again; your draft is kept.")

Line: TypeAlias = Annotated[str, msgspec.Meta(max_length=4 * LONGEST_TEXT)]
Point: TypeAlias = tuple[Coordinate, Coordinate]


class SentShape(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A drawn point, box or path."""

    points: Annotated[list[Point], msgspec.Meta(min_length=1, max_length=MOST_POINTS)]
    label: Line = ""


class SentAnswer(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The answer to a question about the picture, or what is drawn there."""

    kind: Literal["words", "count", "attribute", "spatial", "point", "boxes", "path"]
    texts: Annotated[list[Line], msgspec.Meta(max_length=3)] = []
    shapes: Annotated[list[SentShape], msgspec.Meta(max_length=50)] = []


class Moment(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A text at a moment."""

    style: Literal["interjection", "vqa", "trace", "memory", "motion", "plan"]
    time_s: Seconds
    text: Line
    reply: Line = ""
    answer: SentAnswer | None = None


class Moments(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A person's texts about an episode, in any order."""

    moments: Annotated[list[Moment], msgspec.Meta(max_length=MOST_MOMENTS)]
    played_to_end: bool = True
    watched_s: Seconds = 0.0
    speed: Speed | None = None


@dataclass(frozen=True, slots=True)
class MomentCounts:
    """Numbers of texts at moments, of those of each style, and of the answers."""

    moments: int
    moments_by_style: dict[str, int]
    episodes_with_moments: int


def times_of(body: Record, style: str) -> list[float]:
    """Return the times of the texts of a style in an answer, in seconds."""
    return [float(one["time_s"]) for one in body["moments"] if one["style"] == style]


def moments_f(one: Record, other: Record, styles: Iterable[str] = STYLES) -> float:
    """Return the F score of two answers' moments.

    Two moments are the same if their styles are, and they are at most `CLOSE_S` apart.
    """
    times = [(times_of(one, style), times_of(other, style)) for style in styles]
    total = sum(len(mine) + len(theirs) for mine, theirs in times)
    return 2.0 * sum(matched_times(*both) for both in times) / total if total else 1.0


def by_agreement(answers: Sequence[Answer], styles: Iterable[str] = STYLES) -> list[Answer]:
    """Return answers to an item in order of their agreement with the others, the best first."""
    named = tuple(styles)

    def agreement(answer: Answer) -> float:
        return sum(moments_f(answer.body, a.body, named) for a in answers if a is not answer)

    return sorted(answers, key=agreement, reverse=True)


def language_of(moment: Record, camera: str | None, source: Record | None = None) -> Language:
    """Return a kept moment as a text of LeRobot's format."""
    style, kept = moment["style"], moment.get("answer")
    answer = None
    if kept is not None:
        shapes = (
            Shape(tuple((float(x), float(y)) for x, y in shape["points"]), shape["label"])
            for shape in kept["shapes"]
        )
        # What moves along a path is the text itself.
        texts = [moment["text"]] if kept["kind"] == PATH else kept["texts"]
        answer = GroundedAnswer(kept["kind"], tuple(texts), tuple(shapes))
    return Language(
        style,
        float(moment["time_s"]),
        moment["text"],
        source or {},
        camera if STYLES[style].has_camera else None,
        answer,
        moment.get("reply", ""),
    )


def _check(
    session: Session, item: AnyItem, answer: Moments, _salt: bytes
) -> tuple[Record, list[FieldProblem]]:
    film = film_of_item(session, item)
    config = restored(session.get_one(Study, item.study_id).config)
    asked = asked_styles(config.tasks.get(MOMENTS.name, TaskConfig()), MOMENTS.words)
    kept = [_kept(moment) for moment in answer.moments]
    problems = [
        FieldProblem(f"moments[{number - 1}]", gettext(message, number=number, **values))
        for number, moment in enumerate(kept, start=1)
        for message, values in _problems(moment, kept[: number - 1], film, asked)
    ]
    if not kept:
        problems.append(FieldProblem("moments", gettext("Write at least one text.")))
    return with_watching({"moments": kept}, answer), problems


def _kept(moment: Moment) -> Record:
    """Return a moment in its kept form: a plan has several lines, other texts one."""
    lines = moment.text.splitlines() if moment.style == PLAN else [moment.text]
    cleaned = [line for line in map(clean_text, lines) if line]
    kept: Record = {
        "style": moment.style,
        "time_s": moment.time_s,
        "text": "\n".join(cleaned),
    }
    if moment.style == INTERJECTION and (reply := clean_text(moment.reply)):
        kept["reply"] = reply
    if moment.answer is not None:
        shapes = [{"points": s.points, "label": clean_text(s.label)} for s in moment.answer.shapes]
        texts = [clean_text(text) for text in moment.answer.texts]
        kept["answer"] = {"kind": moment.answer.kind, "texts": texts, "shapes": shapes}
    return kept


def _problems(
    moment: Record, earlier: Sequence[Record], film: Film, asked: Iterable[str]
) -> Iterator[tuple[str, dict[str, Any]]]:
    camera = str(film.metadata.get("camera", ""))
    kind = (moment.get("answer") or {}).get("kind")
    fault = language_of(moment, camera).fault({camera: film.size})
    if moment["style"] not in asked or (kind is not None and (kind == PATH) != _is_path(moment)):
        yield OTHER_FAULT, {}
    elif fault is not None:
        yield FAULTS.get(fault, OTHER_FAULT), {}
    if max(map(len, _texts(moment))) > LONGEST_TEXT:
        yield (
            N_("Use at most %(most)s characters for a text at number %(number)s."),
            {"most": LONGEST_TEXT},
        )
    if moment["time_s"] > film.duration_s + SLACK_S:
        yield N_("Number %(number)s is after the video's end."), {}
    frame_s = 1.0 / film.fps if film.fps else 0.0
    for place, other in enumerate(earlier, start=1):
        is_near = abs(other["time_s"] - moment["time_s"]) < max(0.5 * frame_s, 1e-3)
        if other["style"] == moment["style"] and is_near:
            message = N_(
                "Numbers %(other)s and %(number)s are of one kind at one moment: move one of them."
            )
            yield message, {"other": place}


def _is_path(moment: Record) -> bool:
    return bool(moment["style"] == TRACE)


def _texts(moment: Record) -> list[str]:
    answer = moment.get("answer") or {"texts": [], "shapes": []}
    labels = [shape["label"] for shape in answer["shapes"]]
    return [moment["text"], moment.get("reply", ""), *answer["texts"], *labels]


def _counts(answers: Sequence[tuple[Record, bool]]) -> Any:
    counts: dict[str, int] = dict.fromkeys(MOMENTS.words.styles, 0)
    for body, _ in answers:
        for moment in body["moments"]:
            counts[moment["style"]] += 1
    return MomentCounts(sum(counts.values()), counts, len(answers))


def _facts(_session: Session, _item: Item, body: Record) -> list[tuple[str, str]]:
    facts = []
    for moment in sorted(body["moments"], key=lambda one: float(one["time_s"])):
        language = language_of(moment, "")
        answer = language.answer.content() if language.answer is not None else language.reply
        text = f"{language.text} – {answer}" if answer else language.text
        facts.append((f"{language.start_s:.1f} s, {language.style}", text))
    return facts


def _add_to_episodes(parts: EpisodeParts) -> None:
    """Add the texts of each episode.

    Everybody's events are added, first those of the answer that agrees best with the others, as
    one is written where several are on a frame. Other texts hold until the next one, so those of a
    style are taken from one answer; they replace the dataset's own.
    """
    by_video = defaultdict(list)
    for answer, item in answers_of(parts.session, parts.study, MOMENTS.name):
        if parts.shows_whole_episode(item.payload["video"]):
            by_video[item.payload["video"]].append(answer)
    added = 0
    for video, answers in by_video.items():
        index, camera = parts.episode(video), parts.videos[video].get("camera")
        texts: list[Language] = []
        for answer in by_agreement(answers):
            source = parts.source(answer, answers=len(answers))
            languages = (language_of(one, camera, source) for one in answer.body["moments"])
            texts += [language for language in languages if language.is_event]
        for style in (name for name in MOMENTS.words.styles if not _is_event(name)):
            some = [answer for answer in answers if times_of(answer.body, style)]
            if some:
                best = by_agreement(some, [style])[0]
                texts += _of_style(parts, best, answers, style)
                parts.replaced[index].add(style)
        parts.language[index] += texts
        added += len(texts)
    parts.counts["moments"] = added


def _is_event(style: str) -> bool:
    return Language(style, 0.0, "").is_event


def _of_style(
    parts: EpisodeParts, best: Answer, answers: Sequence[Answer], style: str
) -> list[Language]:
    scores = [moments_f(best.body, a.body, [style]) for a in answers if a is not best]
    agreement = sum(scores) / len(scores) if scores else None
    source = parts.source(best, answers=len(answers), agreement=agreement)
    return [language_of(m, None, source) for m in best.body["moments"] if m["style"] == style]


MOMENTS = Task(
    name="moments",
    words=TaskWords(
        title=N_("Moments"),
        summary=N_("Watch a video and write texts at moments of it."),
        offer=N_("Watch short videos and write texts at moments of them."),
        instructions=(
            N_("Watch the video to its end. You may watch it again as often as you like."),
            N_("Go to a moment, choose what you write there, and type it."),
            N_(
                "Some texts are about the picture at that moment: you can draw points, boxes or a "
                "line in it."
            ),
            N_("Write only what the video shows or fits to what comes next in it."),
        ),
        keys=(
            (N_("1 to 6"), N_("write a text of this kind here")),
            (N_("Esc"), N_("end drawing")),
            *VIDEO_KEYS,
        ),
        styles={
            INTERJECTION: StyleWords(
                N_("Interjection"),
                N_("What could a person tell the robot now, so that it does what comes next?"),
                is_usual=True,
            ),
            VQA: StyleWords(
                N_("Question and answer"),
                N_("Ask something that the picture shows, and answer it."),
                is_usual=True,
            ),
            TRACE: StyleWords(
                N_("Path in the picture"),
                N_("Draw the way that the hand, or a thing, takes from here on."),
            ),
            MEMORY: StyleWords(
                N_("Memory"),
                N_("What has the robot done so far? Let it speak: “I opened the drawer.”"),
            ),
            MOTION: StyleWords(
                N_("Motion"),
                N_("How does the robot move from here on? “Move left, close the gripper.”"),
            ),
            PLAN: StyleWords(N_("Plan"), N_("What is left to do from here on? A step a line.")),
        },
    ),
    template="tasks/moments.html",
    answer=Moments,
    payload=video_payload,
    check=_check,
    example=lambda scene: scene.watched,
    hides_title=True,
    watches=its_video,
    practises=("video",),
    of_video=item_of_video("moments"),
    counts=Counts(MomentCounts, _counts, {"moments": "moments"}),
    facts=_facts,
    agreement=(mean_of_pairs({f"moments within {CLOSE_S:g} s, F": moments_f}),),
    episodes=_add_to_episodes,
)
