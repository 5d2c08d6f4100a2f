"""Drawing boxes and outlines in the pictures of a draft's videos."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import flask
import msgspec
import numpy as np
from flask import Blueprint, Response
from flask.typing import ResponseReturnValue

from annotation_app.core.problems import Refusal
from annotation_app.making.added_files import folder_of
from annotation_app.making.step_forms import use_file
from annotation_app.making.step_pages import opened_draft, opened_video, page_values, pictured
from annotation_app.making.steps import STEPS, parts_of
from annotation_app.store.installation import installation
from annotation_app.study_setup.drawn_things import (
    DrawnPicture,
    DrawnThing,
    Moment,
    Outline,
    drawn_things,
    names_in,
    state_of,
    write_drawn,
)
from annotation_app.study_setup.own_videos import OwnVideo
from annotation_app.study_setup.prepared_videos import looked_at, part_of, png
from annotation_app.study_setup.study_drafts import StudyDraft, keep_draft
from annotation_app.web.api import json_reply, read_request
from annotation_app.web.who_asks import changed_by, refused, seen_by
from corpus_tools.video.cutting import constant_rate, pictures, span
from corpus_tools.video.outline_tracking import STEP_S, Moved, carry_on, thinned
from corpus_tools.video.picture_file import decoded
from corpus_tools.world.scenarios.documents import read_document
from g3.errors import CorpusError, FormatError
from g3.storage import regular_file
from g3.storage.only_writer import only_writer

DRAWN = "drawn"
CHUNK_S = 5.0
"""Seconds of a video through which outlines are carried on in one request."""
NEAR = 8
"""Largest number of other videos that a page lists before and after its own."""
MOST_WAIT_S = 10.0
TOLERANCE = 1 / 500
"""Part of the picture's width by which a moment that is left out may differ."""

blueprint = Blueprint("making_drawing", __name__, url_prefix="/admin/studies")


@blueprint.errorhandler(Refusal)
def _refused(refusal: Refusal) -> ResponseReturnValue:
    if flask.request.method == "POST":
        return flask.jsonify({"error": refusal.message}), refusal.status
    return refused(refusal)


@blueprint.errorhandler(CorpusError)
def _cannot_be_done(error: CorpusError) -> ResponseReturnValue:
    return _refused(Refusal(422, str(error)))


class SentThings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The things of a video, and the state of those that they take the place of."""

    video: str
    state: str
    things: list[DrawnThing]


class Carried(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Outlines at a moment of a video, to be carried on."""

    start_s: Annotated[float, msgspec.Meta(ge=0, le=1e6)]
    outlines: Annotated[list[Outline], msgspec.Meta(min_length=1, max_length=50)]


@blueprint.get("/<name>/video/<int:number>/draw")
def draw(name: str, number: int) -> str:
    """Show a video with what is drawn in it."""
    with seen_by("admin") as (_, admin):
        draft, item = _own_video(name, number)
    parts, _ = parts_of(installation().config.studies_folder, draft, are_played=False)
    info = looked_at(item.file)
    of_part = part_of(item).span(info)
    width, height = _size(item)
    address: dict[str, Any] = {"name": name, "number": number}
    has_still = item.things is not None and item.things.picture is not None
    data = {
        "video": item.video,
        "state": state_of(item.things),
        "width": width,
        "height": height,
        "things": drawn_things(item.things),
        "duration_s": of_part.duration_s,
        "fps": constant_rate(info, of_part),
        "still": flask.url_for(".still", **address) if has_still else None,
        "film": flask.url_for("making_previews.video", **address),
        "save": flask.url_for(".save", **address),
        "follow": flask.url_for(".follow", **address),
    }
    videos = pictured(draft, parts)
    return flask.render_template(
        "making/draw.html",
        person=admin,
        draft=draft,
        step=STEPS[0],
        data=msgspec.to_builtins(data),
        names=names_in(_things_file(draft)),
        item=item,
        near=videos[max(0, number - NEAR) : number + NEAR + 1],
        following=videos[number + 1] if number + 1 < len(videos) else None,
        problems=[],
        **page_values(draft),
    )


@blueprint.get("/<name>/video/<int:number>/still")
def still(name: str, number: int) -> Response:
    """Send the picture in which the things of a video are marked, if it isn't a frame of it."""
    _, item = _own_video(name, number)
    if item.things is None or item.things.picture is None:
        raise Refusal(404, "There is no picture of this.")
    file = item.things.picture
    content = decoded(regular_file.read_bytes(file), where=str(file))
    return Response(png(np.ascontiguousarray(content[..., ::-1])), mimetype="image/png")


@blueprint.post("/<name>/video/<int:number>/things")
def save(name: str, number: int) -> Response:
    """Keep what is drawn in a video in the draft's own file of things."""
    draft, item = _own_video(name, number)
    sent = read_request(SentThings)
    root = installation().config.studies_folder
    folder_of(draft).mkdir(parents=True, exist_ok=True)
    with changed_by("admin") as (session, _), only_writer(folder_of(draft) / f"{DRAWN}.json"):
        draft = opened_draft(session, name)
        parts, _ = parts_of(root, draft, are_played=False)
        videos = [] if parts is None else [v for v in parts.videos if isinstance(v, OwnVideo)]
        item = next((one for one in videos if one.video == sent.video), item)
        if item.video != sent.video or state_of(item.things) != sent.state:
            raise Refusal(409, "Somebody else has changed this. Load the page again.")
        _check_moments(item, sent.things)
        source, target = _things_file(draft), _drawn_file(draft)
        drawn = DrawnPicture(item.video, *_size(item), sent.things, item.things)
        write_drawn(source, target, {one.video: one.file for one in videos}, drawn)
        value = dict(draft.value)
        use_file(value, "things", target, draft)
        keep_draft(root, draft, value)
    return json_reply({"state": state_of(_own_video(name, number)[1].things)})


@blueprint.post("/<name>/video/<int:number>/follow")
def follow(name: str, number: int) -> Response:
    """Carry outlines on through the next seconds of a video."""
    _, item = _own_video(name, number)
    sent = read_request(Carried)
    info = looked_at(item.file)
    of_part = part_of(item).span(info)
    start_s = of_part.start_s + sent.start_s
    end_s = min(start_s + CHUNK_S, of_part.end_s)
    found: list[tuple[float, list[Moved]]] = []
    until = time.monotonic() + MOST_WAIT_S
    outlines = [[np.array(p, dtype=np.float64) for p in one] for one in sent.outlines]
    if sent.start_s < of_part.duration_s:
        frames = pictures(item.file, info, span(info, start_s, end_s))
        for at_s, moved in carry_on(frames, outlines):
            found.append((at_s - of_part.start_s, moved))
            if time.monotonic() > until:
                break
    of_things = [
        _moments([(t, moved[n]) for t, moved in found], sent.start_s, TOLERANCE * _size(item)[0])
        for n in range(len(sent.outlines))
    ]
    last_s = found[-1][0] if found else of_part.duration_s
    is_end = not found or last_s > of_part.duration_s - max(2 * STEP_S, 2 / info.fps)
    return json_reply(
        {
            "things": [moments for moments, _ in of_things],
            "lost_s": [lost_s for _, lost_s in of_things],
            "until_s": last_s,
            "is_end": is_end,
        }
    )


def _moments(
    found: Sequence[tuple[float, Moved]], start_s: float, tolerance: float
) -> tuple[list[Moment], float | None]:
    """Return a thing's moments after the start, as few as show its way, and when it was lost."""
    there = [(t, outline) for t, outline in found if outline is not None and t > start_s]
    lost_s = next((t for t, outline in found if outline is None), None)
    if not there:
        return [], lost_s
    times = np.array([t for t, _ in there])
    values = np.array([np.concatenate(outline).ravel() for _, outline in there])
    kept = thinned(times, values, tolerance)
    moments = [
        Moment(
            round(there[i][0], 3),
            [[(x, y) for x, y in polygon.round(1).tolist()] for polygon in there[i][1]],
            is_keyframe=False,
        )
        for i in kept
    ]
    return moments, lost_s


def _own_video(name: str, number: int) -> tuple[StudyDraft, OwnVideo]:
    draft, item = opened_video(name, number)
    if not isinstance(item, OwnVideo):
        raise Refusal(404, "What is where in videos of `ct render-videos` is known already.")
    return draft, item


def _size(item: OwnVideo) -> tuple[int, int]:
    """Return width and height of the picture in which a video's things are marked."""
    if item.things is not None:
        return item.things.width, item.things.height
    info = looked_at(item.file)
    return info.width, info.height


def _check_moments(item: OwnVideo, things: Sequence[DrawnThing]) -> None:
    has_still = item.things is not None and item.things.picture is not None
    duration_s = part_of(item).span(looked_at(item.file)).duration_s
    latest = max((one.time_s for thing in things for one in thing.moments), default=0.0)
    if latest > (0.0 if has_still else duration_s):
        what = f"something is drawn at {latest:g} s, where there is no picture"
        raise FormatError(what, where=item.video, fix="load the page again")


def _things_file(draft: StudyDraft) -> Path | None:
    named = draft.value.get("things")
    return (draft.file.parent / str(named)).resolve() if named else None


def _drawn_file(draft: StudyDraft) -> Path:
    """Return the file for what is drawn: a new one where the running study has the earlier one."""
    folder = folder_of(draft).resolve()
    current, running = _things_file(draft), None
    if not draft.is_new:
        before = read_document(draft.file).value.get("things")
        running = (draft.file.parent / str(before)).resolve() if before else None
    names = (f"{DRAWN}.json", *(f"{DRAWN}-{n}.json" for n in range(2, 1000)))
    for file in (folder / one for one in names):
        if (file == current and file != running) or not file.exists():
            return file
    raise FormatError("there are too many drawn files", where=str(folder), fix="delete some")
