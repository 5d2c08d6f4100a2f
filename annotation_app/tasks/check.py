"""Check: people judge the match of clauses and groundings drawn at random for them.

An item's payload is ``{"video", "text", "command", "sdcs", "grounding": id of the answer, "shown":
{node: {"video", "objects": [ids], "places": [indices]}}}``. Where nobody knows what is where in
videos, there is no grounding, and another video is drawn for what happens. The page sends
``{"verdicts": {node: True, False or "cant_tell"}}``, which is kept. The answers make a corpus's
negatives (section 4.1).
"""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import IO, Any, Literal

import msgspec
import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.core.languages import N_, gettext
from annotation_app.core.problems import FieldProblem
from annotation_app.items.assignment import AnyItem
from annotation_app.items.item_scenes import aliases_of, has_things, scene_of, shown_film
from annotation_app.items.media import media_files
from annotation_app.items.new_items import NewItem, about_answer, draws, other_video, videos_of
from annotation_app.items.scenes import place_names, scene_payload, thing_names
from annotation_app.store.models import Answer, Item, Record, Study
from annotation_app.studies.study_file import StudyConfig
from annotation_app.tasks.agreement import (
    CLAUSE_TYPE,
    WORDS,
    Part,
    by_clause,
)
from annotation_app.tasks.clause_words import HAPPENING, clauses_of
from annotation_app.tasks.corpus_parts import CorpusParts, answers_of
from annotation_app.tasks.drawn_answers import marked_things
from annotation_app.tasks.exported_groundings import checked_negative
from annotation_app.tasks.practice_example import OwnPractice, PracticeExample
from annotation_app.tasks.task_record import (
    CLAUSES,
    EDITOR_KEYS,
    GROUNDINGS,
    AnswerTable,
    Counts,
    Source,
    Task,
    TaskWords,
    write_csv,
)
from annotation_app.tasks.watched_videos import Seconds, Speed, with_watching
from g3.sdc.clauses import breadth_first
from g3.sdc.sdc_notation import from_json, to_json

COLUMNS = (
    "item", "command", "video", "shown_video", "clause", "type", "phrase", "objects", "places",
    "shown", "matches", "does_not_match", "cant_tell", "label",
)  # fmt: skip


class Checked(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Verdicts on the match of clauses and the groundings shown with them."""

    verdicts: dict[str, bool | Literal["cant_tell"]]
    watched_s: Seconds | None = None
    speed: Speed | None = None


@dataclass(frozen=True, slots=True)
class CheckCounts:
    """The number of clauses checked."""

    checks: int


def _payload(session: Session, item: Item, salt: bytes) -> Record:
    shown = item.payload["shown"]
    videos = list(dict.fromkeys(shown[node]["video"] for node in shown))
    known = [video for video in videos if has_things(session, item.study_id, video)]
    worlds = {video: aliases_of(session, item, video, salt) for video in known}
    clauses = []
    for clause in clauses_of(from_json(item.payload["sdcs"])):
        grounding = shown.get(str(clause["node"]))
        if grounding is None:
            continue
        found: Record = {"scene": videos.index(grounding["video"]), "objects": [], "places": []}
        if grounding["video"] in worlds:
            names = worlds[grounding["video"]][1]
            objects = {real: alias for alias, real in names.objects.items()}
            places = {index: alias for alias, index in names.places.items()}
            found["objects"] = [objects[real] for real in grounding["objects"]]
            found["places"] = [places[index] for index in grounding["places"]]
        clauses.append({**clause, "shown": found})
    return {
        "command": item.payload["text"],
        "sdcs": item.payload["sdcs"],
        "clauses": clauses,
        "scenes": [
            scene_payload(*worlds[video], media_files(session, item.study_id, video).public)
            if video in worlds
            else shown_film(session, item.study_id, video)
            for video in videos
        ],
    }


def _check(
    _session: Session, item: AnyItem, answer: Checked, _salt: bytes
) -> tuple[Record, list[FieldProblem]]:
    shown = item.payload["shown"]
    missing = sorted(shown.keys() - answer.verdicts.keys(), key=int)
    unknown = sorted(answer.verdicts.keys() - shown.keys())
    problems = [FieldProblem(node, gettext("Tell whether this matches.")) for node in missing]
    problems += [
        FieldProblem(node, gettext("There is no such clause to check.")) for node in unknown
    ]
    return with_watching({"verdicts": dict(answer.verdicts)}, answer), problems


def _watched(payload: Record) -> list[str]:
    """Return the videos that show what happens: pictures of them show things and places."""
    shown = payload["shown"].values()
    return sorted({one["video"] for one in shown if not (one["objects"] or one["places"])})


def _items(session: Session, config: StudyConfig, item: Item, answer: Answer) -> Iterable[NewItem]:
    subject = about_answer(answer)
    shown = random_groundings(session, item, answer.body, draws(config, subject))
    if shown:
        about = {key: item.payload[key] for key in ("text", "command", "video", "sdcs")}
        yield NewItem("check", subject, {**about, "grounding": answer.id, "shown": shown})


def random_groundings(
    session: Session, item: Item, body: Record, rng: np.random.Generator
) -> Mapping[str, Record]:
    """Draw as many random groundings for each clause as it has right ones (section 4.1).

    Things come from all videos in which they are known; what happens comes from another video than
    the command's.
    """
    own = item.payload["video"]
    videos = [
        video
        for video in videos_of(session, item.study_id)
        if has_things(session, item.study_id, video)
    ]
    shown: dict[str, Record] = {}
    for node, sdc in enumerate(breadth_first(from_json(item.payload["sdcs"]))):
        if sdc.type in HAPPENING:
            other = other_video(session, item.study_id, own, rng)
            if other is not None:
                shown[str(node)] = {"video": other, "objects": [], "places": []}
            continue
        right = body["groundings"].get(str(node))
        marked = marked_things(body, right) if right is not None else []
        count = len(marked) + len(right["places"]) if right is not None else 0
        if right is None or not count:
            continue
        video = videos[int(rng.integers(len(videos)))]
        context = scene_of(session, item.study_id, video).context
        kind = "objects" if right["objects"] or not context.places else "places"
        pool: list[Any] = (
            [o.id for o in context.objects] if kind == "objects" else [*range(len(context.places))]
        )
        if video == own:
            known = [place.get("place") for place in right["places"]]
            pool = [thing for thing in pool if thing not in (*right["objects"], *known)]
        picks = rng.choice(len(pool), size=min(count, len(pool)), replace=False)
        drawn: Record = {"video": video, "objects": [], "places": []}
        drawn[kind] = [pool[int(i)] for i in sorted(picks)]
        if drawn[kind]:
            shown[str(node)] = drawn
    return shown


def _export(parts: CorpusParts) -> None:
    """Add what was drawn at random for adopted groundings, as far as somebody has checked it."""
    session, study = parts.session, parts.study
    verdicts: dict[str, list[Record]] = {}
    for answer, item in answers_of(session, study, "check", adopted=True):
        verdicts.setdefault(item.id, []).append(answer.body["verdicts"])
    still_adopted = {answer.id for answer, _ in answers_of(session, study, "ground", adopted=True)}
    items = session.scalars(
        select(Item).where(Item.study_id == study.id, Item.task == "check").order_by(Item.subject)
    )
    for item in items:
        worlds = {shown["video"] for shown in item.payload["shown"].values()}
        if not worlds <= parts.worlds.keys():
            continue  # tables tell of what nobody knows a world of
        if item.id in verdicts and item.payload.get("grounding") in still_adopted:
            command = parts.commands[item.payload["command"]]
            parts.annotations.append(
                checked_negative(item, command, parts.worlds, verdicts[item.id])
            )


def _without_scenes(
    session: Session, config: StudyConfig, item: Item, answer: Answer
) -> Iterable[NewItem]:
    """Yield an item that asks if another video shows a command's EVENTs and PATHs.

    It is drawn from the study's videos, but not from those for which somebody has given the very
    same command. There is none where it is known what is where: then things are drawn, too.
    """
    own, text = item.payload["video"], item.payload["text"]
    if has_things(session, item.study_id, own):
        return
    same = select(Item.video).where(
        Item.study_id == item.study_id, Item.task == item.task, Item.command == text
    )
    sdcs = answer.body["sdcs"]
    nodes = [c["node"] for c in clauses_of(from_json(sdcs)) if c["type"] in HAPPENING]
    subject = about_answer(answer)
    video = other_video(session, item.study_id, own, draws(config, subject), same)
    if video is not None and nodes:
        shown = {str(node): {"video": video, "objects": [], "places": []} for node in nodes}
        about = {"text": text, "command": item.payload["command"], "video": own, "sdcs": sdcs}
        yield NewItem("check", subject, {**about, "shown": shown})


def _table(session: Session, study: Study, file: IO[bytes]) -> None:
    write_csv(file, COLUMNS, _rows(session, study))


def _rows(session: Session, study: Study) -> Iterator[tuple[object, ...]]:
    """Yield each clause that was checked with the things shown, and its counts of verdicts."""
    found: dict[str, tuple[Item, list[Record]]] = {}
    for answer, item in answers_of(session, study, "check", adopted=True):
        found.setdefault(item.id, (item, []))[1].append(answer.body["verdicts"])
    for item, verdicts in found.values():
        for clause in clauses_of(from_json(item.payload["sdcs"])):
            shown = item.payload["shown"].get(str(clause["node"]))
            given = Counter(v[str(clause["node"])] for v in verdicts if str(clause["node"]) in v)
            if shown is not None:
                yes, no = given[True], given[False]
                label = "" if yes == no else "true" if yes > no else "false"
                places = " ".join(map(str, shown["places"]))
                about = (item.id, item.payload["text"], item.payload["video"], shown["video"])
                of = (clause["node"], clause["type"], clause["phrase"])
                counts = (yes, no, given["cant_tell"], label)
                names = _shown_names(session, item, shown)
                yield (*about, *of, " ".join(shown["objects"]), places, names, *counts)


VERDICTS = {True: "matches", False: "doesn't match", "cant_tell": "can't tell"}


def _facts(session: Session, item: Item, body: Record) -> Iterator[tuple[str, str]]:
    for clause in clauses_of(from_json(item.payload["sdcs"])):
        node = str(clause["node"])
        if node in body["verdicts"]:
            shown = _shown_names(session, item, item.payload["shown"][node])
            yield f"{clause['phrase']}: {shown}", VERDICTS[body["verdicts"][node]]


def _shown_names(session: Session, item: Item, shown: Record) -> str:
    """Return the names of what was drawn for a clause; that of the video if it is what happens."""
    if not (shown["objects"] or shown["places"]):
        return f"what happens in {shown['video']}"
    context = scene_of(session, item.study_id, shown["video"]).context
    things, places = thing_names(context), place_names(context)
    names = [things.get(one, one) for one in shown["objects"]]
    return ", ".join([*names, *(places[index] for index in shown["places"])])


def _example(practice: PracticeExample) -> Record:
    shown = {"scene": 0, "objects": ["thing-b"], "places": []}
    return {
        "command": practice.command,
        "sdcs": practice.sdcs,
        "clauses": [
            {**clause, "shown": shown} for clause in practice.clauses if clause["type"] == "OBJECT"
        ],
        "scenes": [practice.scene],
    }


def _own_example(own: OwnPractice) -> Record:
    """Draw a thing for each OBJECT, the same each time; what happens is in the video."""
    sdcs = own.sdcs()
    shown = own.scene()
    things = sorted(thing["id"] for thing in shown["map"]["objects"])
    rng = np.random.default_rng(zlib.crc32(own.command.encode()))
    clauses = []
    for clause in clauses_of(sdcs):
        drawn: list[str] = []
        if clause["type"] == "OBJECT" and things:
            drawn = [things[int(rng.integers(len(things)))]]
        if drawn or clause["type"] in HAPPENING:
            clauses.append({**clause, "shown": {"scene": 0, "objects": drawn, "places": []}})
    return {
        "command": own.command,
        "sdcs": to_json(sdcs),
        "clauses": clauses,
        "scenes": [shown],
    }


def _counts(answers: Sequence[tuple[Record, bool]]) -> Any:
    return CheckCounts(sum(len(body["verdicts"]) for body, _ in answers))


def _disputed(item: Item, bodies: Sequence[Record]) -> Iterator[Part]:
    for clause in clauses_of(from_json(item.payload["sdcs"])):
        node = str(clause["node"])
        verdicts = {str(body["verdicts"][node]) for body in bodies if node in body["verdicts"]}
        if verdicts:
            yield Part(CLAUSE_TYPE, clause["type"], len(verdicts) > 1)
            yield Part(WORDS, clause["phrase"].lower(), len(verdicts) > 1)


CHECK = Task(
    name="check",
    words=TaskWords(
        title=N_("Check"),
        summary=N_("Tell whether parts of a command match what is shown."),
        offer=N_("Tell whether parts of commands match what is shown."),
        instructions=(
            N_(
                "For each clause something is shown that was drawn at random. It may be what the "
                "words mean, or not."
            ),
            N_("Where words say what happens, watch the video to its end."),
            N_(
                "Choose “It matches” if the words of this clause could well mean what is shown, "
                "looking at nothing but these words."
            ),
            N_("Choose “It doesn't match” if nobody would mean this by the words."),
            N_("Go on with “Next clause” until every clause has a tick."),
        ),
        keys=(
            ("Y N X", N_("it matches, it doesn't, can't tell")),
            ("[ ]", N_("go from clause to clause")),
            *EDITOR_KEYS,
        ),
    ),
    template="tasks/check.html",
    answer=Checked,
    payload=_payload,
    check=_check,
    example=_example,
    own_example=_own_example,
    practises=("video", "command"),
    reads=("labels",),
    watches=_watched,
    needs_scenes=True,
    source=Source(
        GROUNDINGS, _items, lambda payload, answer: payload.get("grounding") == answer.id
    ),
    without_scenes=Source(
        CLAUSES, _without_scenes, lambda payload, answer: payload["sdcs"] == answer.body["sdcs"]
    ),
    export=_export,
    tables={
        "checks.csv": AnswerTable(
            "Checked negatives (CSV)",
            "text/csv",
            _table,
            "a row for each clause that was checked, and how many said that it matches",
        )
    },
    counts=Counts(CheckCounts, _counts, {"checks": "checked negatives"}),
    agreement=(by_clause("verdicts", str),),
    gist=lambda body: {"verdicts": body["verdicts"]},
    disputed=_disputed,
    facts=lambda *about: [*_facts(*about)],
)
