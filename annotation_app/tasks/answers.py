"""What people may answer, and what they are told if an answer can't be kept.

Answers come in the form that the page's script sends, with the ids that the page was told;
they are kept with real ones:

describe
    ``{"text"}``, with the video watched: ``{"played_to_end", "watched_s"}``
segment
    ``{"sdcs"}`` as :func:`g3.sdc.sdc_notation.to_json` writes them
ground
    ``{"groundings": {node: {"objects": [ids], "places": [{"xy"} or {"place": index}],
    "cant_tell", "time_s"}}, "trims": {node: [start_s, end_s]}}``
check
    ``{"verdicts": {node: True, False or "cant_tell"}}``
rate
    ``{"rating": 1 to 5}``
"""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import Annotated, Any, Literal, TypeAlias, TypeVar

import msgspec
import numpy as np
from sqlalchemy.orm import Session

from annotation_app.core.problems import FieldProblem, Refusal
from annotation_app.store.models import Item, Record
from annotation_app.tasks.assignment import AnyItem
from annotation_app.tasks.payloads import aliases_of
from annotation_app.tasks.scenes import Aliases, Scene
from g3.errors import SDCError
from g3.geometry.plane import area, convex_hull
from g3.sdc.clauses import SDC, all_words, breadth_first
from g3.sdc.sdc_notation import from_json, to_json

LONGEST_TEXT = 2000
LONGEST_COMMAND_WORDS = 200
MOST_THINGS = 50
DEEPEST_JSON = 40
SMALLEST_PLACE_M2 = 0.01
FAR_M = 200.0
"""How far from the map's things a place may be marked."""

T = TypeVar("T", bound=msgspec.Struct)
Seconds: TypeAlias = Annotated[float, msgspec.Meta(ge=0, le=1e6)]
Coordinate: TypeAlias = Annotated[float, msgspec.Meta(ge=-1e6, le=1e6)]


class Described(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A command for what a video shows."""

    text: str
    played_to_end: bool
    watched_s: Seconds = 0.0


class Segmented(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The SDC trees of a command."""

    sdcs: list[dict[str, Any]]


class MarkedPlace(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A place: one of the map's, or corners on the map."""

    xy: Annotated[list[tuple[Coordinate, Coordinate]], msgspec.Meta(max_length=100)] | None = None
    place: str | None = None


class ClauseGrounding(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What a clause refers to."""

    objects: Annotated[list[str], msgspec.Meta(max_length=MOST_THINGS)] = []
    places: Annotated[list[MarkedPlace], msgspec.Meta(max_length=MOST_THINGS)] = []
    cant_tell: bool = False
    time_s: Seconds = 0.0


class Grounded(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The groundings of a command's clauses."""

    groundings: dict[str, ClauseGrounding]
    trims: dict[str, tuple[Seconds, Seconds]] = {}


class Checked(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Whether clauses match what was shown with them."""

    verdicts: dict[str, bool | Literal["cant_tell"]]


class Rated(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How much somebody agrees: 1 strongly disagrees, 5 strongly agrees."""

    rating: Annotated[int, msgspec.Meta(ge=1, le=5)]


ANSWERS: dict[str, type[msgspec.Struct]] = {
    "describe": Described,
    "segment": Segmented,
    "ground": Grounded,
    "check": Checked,
    "rate": Rated,
}
"""The form of each task's answers."""


def read_answer(session: Session, item: AnyItem, body: Record, salt: bytes) -> Record:
    """An answer as it is kept.

    Raises
    ------
    Refusal
        With all that is wrong with it, in plain words.
    """
    try:
        answer = msgspec.convert(body, ANSWERS[item.task])
    except msgspec.ValidationError as error:
        what, _, field = str(error).rstrip("`").partition(" - at `$")
        message = "This part of the answer can't be read. Load the page again; your draft is kept."
        problem = FieldProblem(field.strip("."), f"{message} ({what})")
        raise Refusal(422, "The answer can't be read.", [problem]) from error
    problems: list[FieldProblem] = []
    kept = _READERS[item.task](session, item, answer, salt, problems)
    if problems:
        raise Refusal(422, "Something in the answer must be changed.", problems)
    return kept


def shown_again(session: Session, item: Item, body: Record, salt: bytes) -> Record:
    """A kept answer in the form in which the page sends it."""
    if item.task != "ground":
        return body
    _, names = aliases_of(session, item, item.payload["video"], salt)
    objects = {real: alias for alias, real in names.objects.items()}
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
    return {"groundings": groundings, "trims": body["trims"]}


def check_json(value: Any, depth: int = 0) -> None:
    """Refuse what no database can keep: NUL characters, and nesting without end.

    Raises
    ------
    Refusal
        With what to do about it.
    """
    if depth > DEEPEST_JSON:
        raise Refusal(422, "This is nested too deeply.")
    if isinstance(value, str) and "\0" in value:
        raise Refusal(
            422,
            "The text has a character that can't be kept (NUL).",
            [FieldProblem("text", "Remove the invisible character NUL, or type the text again.")],
        )
    parts: Iterable[Any] = ()
    if isinstance(value, dict):
        parts = (*value.keys(), *value.values())
    elif isinstance(value, list):
        parts = value
    for part in parts:
        check_json(part, depth + 1)


def clean_text(text: str) -> str:
    """Text in Unicode's normal form C, in one line, without control characters."""
    joined = " ".join(text.split())
    kept = (c for c in joined if unicodedata.category(c) != "Cc")
    return unicodedata.normalize("NFC", "".join(kept)).strip()


def _described(
    _session: Session, _item: AnyItem, answer: Any, _salt: bytes, problems: list[FieldProblem]
) -> Record:
    text = clean_text(answer.text)
    if not answer.played_to_end:
        problems.append(FieldProblem("played_to_end", "Watch the video to its end first."))
    if not any(character.isalnum() for character in text):
        problems.append(FieldProblem("text", "Type what you would tell the operator to do."))
    elif len(text) > LONGEST_TEXT:
        problems.append(
            FieldProblem(
                "text", f"This is {len(text)} characters long. Use at most {LONGEST_TEXT}."
            )
        )
    elif len(text.split()) > LONGEST_COMMAND_WORDS:
        problems.append(
            FieldProblem("text", f"Use at most {LONGEST_COMMAND_WORDS} words for the command.")
        )
    return {"text": text, "watched_s": answer.watched_s}


def _segmented(
    _session: Session, item: AnyItem, answer: Any, _salt: bytes, problems: list[FieldProblem]
) -> Record:
    try:
        sdcs = from_json(answer.sdcs)
    except SDCError as error:
        message = f"{error.what[:1].upper()}{error.what[1:]}."
        problems.append(FieldProblem(error.where, f"{message} {error.fix}".strip()))
        return {}
    problems += segmentation_problems(sdcs, item.payload["text"])
    return {"sdcs": to_json(sdcs)}


def segmentation_problems(sdcs: tuple[SDC, ...], text: str) -> list[FieldProblem]:
    """What is wrong with the SDC trees of a command, beyond their form."""
    problems = []
    if not any(not sdc.is_implicit for sdc in breadth_first(sdcs)):
        problems.append(FieldProblem("sdcs", "Mark at least one clause."))
    for i, tree in enumerate(sdcs):
        words = all_words(tree)
        for word in words:
            if text[word.start : word.end] != word.text:
                problems.append(
                    FieldProblem(f"sdcs[{i}]", f'"{word.text}" is not in the command there.')
                )
        for word in sorted({w for w, following in pairwise(words) if w == following}):
            problems.append(
                FieldProblem(
                    f"sdcs[{i}]", f'The word "{word.text}" is used twice. Use it in one place.'
                )
            )
    for node, sdc in enumerate(breadth_first(sdcs)):
        is_figure = any(sdc is figure for parent in breadth_first(sdcs) for figure in parent.figure)
        if sdc.is_implicit and not (sdc.type == "OBJECT" and is_figure):
            problems.append(
                FieldProblem(str(node), "This clause has no words. Give it some, or remove it.")
            )
    return problems


def _grounded(
    session: Session, item: AnyItem, answer: Any, salt: bytes, problems: list[FieldProblem]
) -> Record:
    scene, names = aliases_of(session, item, item.payload["video"], salt)
    nodes = list(breadth_first(from_json(item.payload["sdcs"])))
    wanted = {
        str(n)
        for n, sdc in enumerate(nodes)
        if sdc.type in ("OBJECT", "PLACE") and not sdc.is_implicit
    }
    trimmed = {str(n) for n, sdc in enumerate(nodes) if sdc.type in ("EVENT", "PATH")}
    for node in sorted(answer.groundings.keys() - wanted):
        problems.append(FieldProblem(node, "There is no such clause to ground."))
    kept = {}
    for node in sorted(wanted, key=int):
        grounding = answer.groundings.get(node)
        if grounding is None or not (grounding.objects or grounding.places or grounding.cant_tell):
            phrase = " ".join(word.text for word in all_words(nodes[int(node)]))
            problems.append(
                FieldProblem(node, f'Show what "{phrase}" is, or choose "can\'t tell".')
            )
        else:
            kept[node] = _clause_grounding(node, grounding, scene, names, problems)
    for node, (start, end) in sorted(answer.trims.items()):
        if node not in trimmed:
            problems.append(FieldProblem(node, "There is no such clause to trim."))
        elif not start < end <= scene.duration_s + 0.5:
            problems.append(FieldProblem(node, "The part of the video must begin before it ends."))
    return {"groundings": kept, "trims": {n: list(trim) for n, trim in answer.trims.items()}}


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
        refuse('Choose either something or "can\'t tell".')
    if len(set(grounding.objects)) < len(grounding.objects):
        refuse("The same object is chosen twice.")
    if not names.objects.keys() >= set(grounding.objects):
        refuse("An object that was chosen isn't in this picture. Choose it again.")
    places: list[Record] = []
    for place in grounding.places:
        if (place.xy is None) == (place.place is None):
            refuse("A place is one of the map's, or has corners.")
        elif place.xy is not None:
            _check_corners(place.xy, scene, refuse)
            places.append({"xy": [list(corner) for corner in place.xy]})
        elif place.place is not None and place.place in names.places:
            places.append({"place": names.places[place.place]})
        else:
            refuse("A place that was chosen isn't on this map. Choose it again.")
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
        refuse("The place is too small. Mark an area, not a point or a line.")
        return
    things = np.concatenate([o.trajectory.xyz[:, :2] for o in scene.context.objects])
    low, high = things.min(axis=0) - FAR_M, things.max(axis=0) + FAR_M
    if (corners < low).any() or (corners > high).any():
        refuse("The place is far outside of the map. Mark it again.")


def _checked(
    _session: Session, item: AnyItem, answer: Any, _salt: bytes, problems: list[FieldProblem]
) -> Record:
    shown = item.payload["shown"]
    for node in sorted(shown.keys() - answer.verdicts.keys(), key=int):
        problems.append(FieldProblem(node, "Tell whether this matches."))
    for node in sorted(answer.verdicts.keys() - shown.keys()):
        problems.append(FieldProblem(node, "There is no such clause to check."))
    return {"verdicts": dict(answer.verdicts)}


def _rated(
    _session: Session, _item: AnyItem, answer: Any, _salt: bytes, _problems: list[FieldProblem]
) -> Record:
    return {"rating": answer.rating}


_READERS = {
    "describe": _described,
    "segment": _segmented,
    "ground": _grounded,
    "check": _checked,
    "rate": _rated,
}
