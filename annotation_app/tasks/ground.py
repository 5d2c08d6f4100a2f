"""Ground: people show in pictures and on a map what the clauses of a command refer to.

An item's payload is ``{"video", "text", "command", "sdcs"}``. The page sends ``{"groundings":
{node: {"objects": [ids], "places": [{"xy"} or {"place": index}], "cant_tell", "time_s"}}, "trims":
{node: [start_s, end_s]}, "whole": [nodes], "drawn": [{"id", "polygons", "time_s"}]}`` with the ids
that it was given, or those of things that people have drawn; real ones are kept, and the parts of
the video as in `annotation_app.tasks.ground`. It is adopted as a
segmentation is.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import IO, Annotated, Any

import msgspec
import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.core.languages import N_, gettext
from annotation_app.core.problems import FieldProblem
from annotation_app.items.assignment import AnyItem
from annotation_app.items.item_scenes import aliases_of, has_things, scene_of
from annotation_app.items.media import media_files
from annotation_app.items.new_items import NewItem, about_answer
from annotation_app.items.scenes import Aliases, Scene, scene_payload, thing_names, with_drawn
from annotation_app.store.models import Answer, Item, Record, Study
from annotation_app.studies.study_file import StudyConfig
from annotation_app.tasks.agreement import by_clause
from annotation_app.tasks.clause_words import HAPPENING, asked_clauses, clauses_of, phrase_of
from annotation_app.tasks.corpus_parts import CorpusParts, answers_of
from annotation_app.tasks.drawn_answers import (
    MOST_DRAWN,
    Coordinate,
    DrawnThing,
    lets_draw,
    marked_things,
    may_draw,
    recognised,
    sent_thing,
)
from annotation_app.tasks.exported_groundings import positive, suggested
from annotation_app.tasks.grounding_comparison import (
    choices_in_words,
    compare,
    disputed_parts,
    essence,
    grounding_key,
    shared_part,
)
from annotation_app.tasks.practice_example import OwnPractice
from annotation_app.tasks.task_record import (
    CLAUSES,
    EDITOR_KEYS,
    GROUNDINGS,
    Adjudication,
    AnswerTable,
    Counts,
    Source,
    Task,
    TaskWords,
    write_csv,
)
from annotation_app.tasks.watched_videos import Seconds, Speed, its_video, with_watching
from g3.geometry.plane import area, convex_hull
from g3.sdc.clauses import SDC, breadth_first
from g3.sdc.sdc_notation import from_json, to_json

MOST_THINGS = 50
SMALLEST_PLACE_M2 = 0.01
FAR_M = 200.0
"""Largest distance of a marked place from the map's things, in metres."""
COLUMNS = (
    "answer", "command", "video", "clause", "type", "phrase", "things", "labels", "boxes", "places",
    "cant_tell", "from_s", "to_s",
)  # fmt: skip


SLACK_S = 0.5
"""Largest time by which a part may exceed a video's end, as players round, in seconds."""


def must_be_chosen(sdcs: tuple[SDC, ...]) -> Mapping[str, str]:
    """Return the nodes for which nothing is preset, and their words."""
    named = [(str(n), sdc) for n, sdc in enumerate(breadth_first(sdcs)) if not sdc.is_implicit]
    if sum(sdc.type == "EVENT" for _, sdc in named) < 2:
        return {}
    return {node: phrase_of(sdc) for node, sdc in named if sdc.type in HAPPENING}


def read_parts(
    sdcs: tuple[SDC, ...],
    trims: Mapping[str, tuple[float, float]],
    whole: Collection[str],
    duration_s: float,
) -> tuple[Record, list[FieldProblem]]:
    """Return a person's chosen parts in their kept form, and the faults of them.

    `whole` has the nodes for which the whole video was chosen, which has this duration.
    """
    known = _happening(sdcs)
    problems: list[FieldProblem] = []

    def refuse(node: str, message: str) -> None:
        problems.append(FieldProblem(node, message))

    for node, (start, end) in sorted(trims.items()):
        if node not in known:
            refuse(node, gettext("There is no such clause to trim."))
        elif not start < end <= duration_s + SLACK_S:
            refuse(node, gettext("The part of the video must begin before it ends."))
    for node in sorted(set(whole)):
        if node not in known:
            refuse(node, gettext("There is no such clause to trim."))
        elif node in trims:
            refuse(node, gettext("Choose either the whole video or a part of it."))
    for node, phrase in must_be_chosen(sdcs).items():
        if node not in trims and node not in whole:
            told = gettext("Choose which part of the video shows “%(phrase)s”.", phrase=phrase)
            refuse(node, told)
    left = [node for node in known if node not in trims]
    kept = {
        "trims": {node: list(trim) for node, trim in trims.items()},
        "whole": {node: "chosen" if node in whole else "preset" for node in left},
    }
    return kept, problems


def sent_parts(sdcs: tuple[SDC, ...], body: Record) -> Record:
    """Return the parts of a kept answer in the form in which a page sends them.

    Answers from before nodes could be chosen have no ``"whole"``: they mean the whole video.
    """
    trims = body["trims"]
    whole = body.get("whole", {n: "chosen" for n in _happening(sdcs) if n not in trims})
    return {"trims": trims, "whole": [node for node, how in whole.items() if how == "chosen"]}


def _happening(sdcs: tuple[SDC, ...]) -> list[str]:
    nodes = enumerate(breadth_first(sdcs))
    return [str(node) for node, sdc in nodes if sdc.type in HAPPENING]


class MarkedPlace(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A place: one of the map's, or corners on the map."""

    xy: Annotated[list[tuple[Coordinate, Coordinate]], msgspec.Meta(max_length=100)] | None = None
    place: str | None = None


class ClauseGrounding(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The referents of a clause."""

    objects: Annotated[list[str], msgspec.Meta(max_length=MOST_THINGS)] = []
    places: Annotated[list[MarkedPlace], msgspec.Meta(max_length=MOST_THINGS)] = []
    cant_tell: bool = False
    time_s: Seconds = 0.0


class Grounded(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The groundings of a command's clauses."""

    groundings: dict[str, ClauseGrounding]
    trims: dict[str, tuple[Seconds, Seconds]] = {}
    whole: list[str] = []
    watched_s: Seconds | None = None
    speed: Speed | None = None
    drawn: Annotated[list[DrawnThing], msgspec.Meta(max_length=MOST_DRAWN)] = []


@dataclass(frozen=True, slots=True)
class GroundingCounts:
    """The number of clauses grounded in adopted answers."""

    groundings: int


def _payload(session: Session, item: Item, salt: bytes) -> Record:
    video = item.payload["video"]
    scene, names = aliases_of(session, item, video, salt)
    sdcs = from_json(item.payload["sdcs"])
    return {
        "command": item.payload["text"],
        "sdcs": item.payload["sdcs"],
        "clauses": asked_clauses(sdcs),
        "asks_parts": bool(must_be_chosen(sdcs)),
        "drawing": may_draw(session, item, scene),
        **scene_payload(scene, names, media_files(session, item.study_id, video).public),
    }


def _sent_form(session: Session, item: Item, body: Record, salt: bytes) -> Record:
    _, names = aliases_of(session, item, item.payload["video"], salt)
    drawn = body.get("drawn", [])
    objects = {real: alias for alias, real in names.objects.items()}
    objects |= {one["id"]: one["id"] for one in drawn}
    places = {index: alias for alias, index in names.places.items()}

    def again(grounding: Record) -> Record:
        return {
            **grounding,
            "objects": [objects[real] for real in grounding["objects"]],
            "places": [
                {"place": places[place["place"]]} if "place" in place else place
                for place in grounding["places"]
            ],
        }

    groundings = {node: again(grounding) for node, grounding in body["groundings"].items()}
    return {
        "groundings": groundings,
        **sent_parts(from_json(item.payload["sdcs"]), body),
        **({"drawn": [sent_thing(one) for one in drawn]} if drawn else {}),
    }


def _shown_suggestion(session: Session, item: Item, suggestion: Record, salt: bytes) -> Any:
    return _sent_form(session, item, {**suggestion, "trims": {}}, salt)["groundings"]


def _check(
    session: Session, item: AnyItem, answer: Grounded, salt: bytes
) -> tuple[Record, list[FieldProblem]]:
    problems: list[FieldProblem] = []
    scene, names = aliases_of(session, item, item.payload["video"], salt)
    sdcs = from_json(item.payload["sdcs"])
    nodes = list(breadth_first(sdcs))
    drawn: dict[str, Record] = {}
    if answer.drawn:
        if not may_draw(session, item, scene):
            problems.append(FieldProblem("drawn", gettext("Nothing can be drawn in this study.")))
        drawn = recognised(session, item, answer.drawn, scene, problems)
        real = {sent: one["id"] for sent, one in drawn.items()}
        names = replace(names, objects={**names.objects, **real})
    wanted = {
        str(n)
        for n, sdc in enumerate(nodes)
        if sdc.type in ("OBJECT", "PLACE") and not sdc.is_implicit
    }
    for node in sorted(answer.groundings.keys() - wanted):
        problems.append(FieldProblem(node, gettext("There is no such clause to ground.")))
    kept = {}
    for node in sorted(wanted, key=int):
        grounding = answer.groundings.get(node)
        if grounding is None or not (grounding.objects or grounding.places or grounding.cant_tell):
            phrase = phrase_of(nodes[int(node)])
            message = gettext("Show what “%(phrase)s” is, or choose “can't tell”.", phrase=phrase)
            problems.append(FieldProblem(node, message))
        else:
            kept[node] = _clause_grounding(node, grounding, scene, names, problems)
    parts, more = read_parts(sdcs, answer.trims, answer.whole, scene.duration_s)
    body = {"groundings": kept, **parts}
    named = {name for grounding in kept.values() for name in grounding["objects"]}
    if used := {one["id"]: one for one in drawn.values() if one["id"] in named}:
        body["drawn"] = list(used.values())
    return with_watching(body, answer), problems + more


def _clause_grounding(
    node: str,
    grounding: ClauseGrounding,
    scene: Scene,
    names: Aliases,
    problems: list[FieldProblem],
) -> Record:
    def refuse(message: str) -> None:
        problems.append(FieldProblem(node, message))

    if grounding.cant_tell and (grounding.objects or grounding.places):
        refuse(gettext("Choose either something or “can't tell”."))
    if len(set(grounding.objects)) < len(grounding.objects):
        refuse(gettext("The same object is chosen twice."))
    if not names.objects.keys() >= set(grounding.objects):
        refuse(gettext("An object that was chosen isn't in this picture. Choose it again."))
    places: list[Record] = []
    for place in grounding.places:
        if (place.xy is None) == (place.place is None):
            refuse(gettext("A place is one of the map's, or has corners."))
        elif scene.is_picture:
            refuse(gettext("There is no map to mark a place on. Choose a thing, or “can't tell”."))
        elif place.xy is not None:
            _check_corners(place.xy, scene, refuse)
            places.append({"xy": [list(corner) for corner in place.xy]})
        elif place.place is not None and place.place in names.places:
            places.append({"place": names.places[place.place]})
        else:
            refuse(gettext("A place that was chosen isn't on this map. Choose it again."))
    return {
        "objects": [names.objects[o] for o in grounding.objects if o in names.objects],
        "places": places,
        "cant_tell": grounding.cant_tell,
        "time_s": grounding.time_s,
    }


def _check_corners(
    xy: list[tuple[float, float]], scene: Scene, refuse: Callable[[str], None]
) -> None:
    corners = np.array(xy, dtype=np.float64).reshape(-1, 2)
    if len(corners) < 3 or area(convex_hull(corners)[None])[0] < SMALLEST_PLACE_M2:
        refuse(gettext("The place is too small. Mark an area, not a point or a line."))
        return
    things = np.concatenate([o.trajectory.xyz[:, :2] for o in scene.context.objects])
    low, high = things.min(axis=0) - FAR_M, things.max(axis=0) + FAR_M
    if (corners < low).any() or (corners > high).any():
        refuse(gettext("The place is far outside of the map. Mark it again."))


def _items(session: Session, _config: StudyConfig, item: Item, answer: Answer) -> Iterable[NewItem]:
    """Yield an item about a command's clauses, if the things in its video are known."""
    video = item.payload["video"]
    if not has_things(session, item.study_id, video) and not lets_draw(session, item.study_id):
        return
    about = {key: item.payload[key] for key in ("text", "command", "video")}
    yield NewItem("ground", about_answer(answer), {**about, "sdcs": answer.body["sdcs"]})


def _export(parts: CorpusParts) -> None:
    """Add adopted groundings; what the study's corpus held stays where nobody has changed it."""
    known = {a.id: a for a in parts.original.annotations} if parts.original else {}
    for answer, item in answers_of(parts.session, parts.study, "ground", adopted=True):
        if item.payload["video"] not in parts.worlds:
            continue  # things in a picture, which tables tell of
        unchanged = known.get(answer.body.get("imported", ""))
        command = parts.commands[item.payload["command"]]
        parts.annotations.append(unchanged or positive(answer, item, command, parts.worlds))
    parts.annotations += [a for a in known.values() if a.source != "positive"]


def named_things(session: Session, study_id: str) -> Mapping[str, set[str]]:
    """Return the ids of the things that answers and items of a study name, by video."""
    found: dict[str, set[str]] = defaultdict(set)
    grounded = (
        select(Item.video, Answer.body)
        .join(Answer, Answer.item_id == Item.id)
        .where(Item.study_id == study_id, Item.task == "ground")
    )
    for video, body in session.execute(grounded):
        for grounding in body["groundings"].values():
            found[video].update(marked_things(body, grounding))
    drawn = select(Item.payload).where(Item.study_id == study_id, Item.task == "check")
    for payload in session.scalars(drawn):
        for shown in payload["shown"].values():
            found[shown["video"]].update(shown["objects"])
    return found


def _counts(answers: Sequence[tuple[Record, bool]]) -> Any:
    bodies = (body for body, adopted in answers if adopted)
    return GroundingCounts(
        sum(not grounding["cant_tell"] for b in bodies for grounding in b["groundings"].values())
    )


def _opened(data: Record, answer: Record) -> Record:
    """Return a page's data whose first state has an answer's parts, and nodes as numbers.

    Adjudicators have seen the video on the page before, and needn't watch it again.
    """
    return {
        **data,
        "start": {**answer, "whole": [int(node) for node in answer["whole"]], "watched_s": 0},
    }


def _table(session: Session, study: Study, file: IO[bytes]) -> None:
    """Write a row for each clause that an adopted answer grounds.

    ``things`` are ids: of annotations, if the things come from a COCO file. ``boxes`` are x, y,
    width and height in pixels of the picture.
    """
    write_csv(file, COLUMNS, _rows(session, study))


def _rows(session: Session, study: Study) -> Iterator[tuple[object, ...]]:
    for answer, item in answers_of(session, study, "ground", adopted=True):
        scene = scene_of(session, study.id, item.payload["video"])
        scene = with_drawn(scene, answer.body.get("drawn", []))
        for clause in clauses_of(from_json(item.payload["sdcs"])):
            node = str(clause["node"])
            grounding = answer.body["groundings"].get(node)
            part = answer.body["trims"].get(node)
            if grounding is not None or part is not None:
                about = (answer.id, item.payload["text"], item.payload["video"], node)
                of = (clause["type"], clause["phrase"])
                yield (*about, *of, *_shown_in(grounding, scene), *(part or ("", "")))


def _shown_in(grounding: Record | None, scene: Scene) -> tuple[object, ...]:
    if grounding is None:
        return "", "", "", "", ""
    ids = grounding["objects"]
    labels = thing_names(scene.context)
    boxes = {one["id"]: one["box"] for one in scene.segmentation.get("objects", [])}
    return (
        " ".join(ids),
        "; ".join(labels.get(one, "") for one in ids),
        _json([boxes.get(one) for one in ids]),
        _json(grounding["places"]),
        grounding["cant_tell"],
    )


def _json(value: object) -> str:
    return msgspec.json.encode(value).decode() if value else ""


def _own_example(own: OwnPractice) -> Record:
    sdcs = own.sdcs()
    return {
        "command": own.command,
        "sdcs": to_json(sdcs),
        "clauses": asked_clauses(sdcs),
        "asks_parts": bool(must_be_chosen(sdcs)),
        "suggestion": None,
        **own.scene(),
    }


GROUND = Task(
    name="ground",
    words=TaskWords(
        title=N_("Ground"),
        summary=N_("Show what the parts of a command refer to."),
        offer=N_("Show in pictures what the parts of commands refer to."),
        instructions=(
            N_("First watch the video. It tells what the command was meant to bring about."),
            N_(
                "Then you are asked about the words of the command, one question after the other."
                " Click what the words mean, in the picture or on the map seen from above. The "
                "next question comes by itself. “Back” and the list lead to earlier ones."
            ),
            N_(
                "If the words mean several things, tick “Several”, click each of them, and press "
                "“Next”."
            ),
            N_(
                "What follows from your answers, such as what “it” is, is shown at the end: say "
                "yes, or click what isn't right and choose another thing."
            ),
            N_("If the words mean a place, choose a dashed one on the map, or mark it there."),
            N_("If a command has several steps, you are also asked when each of them begins."),
            N_("Choose “Can't tell” if you have looked and still don't know."),
        ),
        keys=(
            ("1, 2, … A, B, …", N_("choose the thing or place with that label, or not")),
            ("[ ]", N_("back, next")),
            ("S", N_("several things, or one")),
            ("X", N_("can't tell")),
            ("Y", N_("yes, to what is proposed")),
            ("E", N_("a step begins here")),
            ("D", N_("draw a box around something, where that is offered")),
            ("M", N_("mark a place: arrows move, + and − size, Enter sets, Esc ends")),
            ("← →", N_("on a handle of the timeline: a frame; with Shift a second")),
            *EDITOR_KEYS,
        ),
    ),
    template="tasks/ground.html",
    answer=Grounded,
    payload=_payload,
    check=_check,
    sent_form=_sent_form,
    example=lambda scene: {
        "command": scene.command,
        "sdcs": scene.sdcs,
        "clauses": asked_clauses(from_json(scene.sdcs)),
        "asks_parts": False,
        "suggestion": None,
        **scene.scene,
    },
    own_example=_own_example,
    practises=("video", "command"),
    suggestion=suggested,
    shown_suggestion=_shown_suggestion,
    likeness=shared_part,
    reads=("labels",),
    watches=its_video,
    needs_scenes=True,
    lets_draw=True,
    gives=GROUNDINGS,
    source=Source(CLAUSES, _items, lambda payload, answer: payload["sdcs"] == answer.body["sdcs"]),
    adjudication=Adjudication(
        essence=essence,
        agreement=shared_part,
        compare=compare,
        opened=_opened,
        template="dashboard/compare_groundings.html",
    ),
    export=_export,
    counts=Counts(GroundingCounts, _counts, {"groundings": "groundings"}),
    agreement=(by_clause("groundings", grounding_key),),
    facts=choices_in_words,
    disputed=disputed_parts,
    tables={
        "groundings.csv": AnswerTable(
            "Groundings (CSV)",
            "text/csv",
            _table,
            "adopted groundings: things with their names and boxes, places, parts of the video",
        )
    },
)
