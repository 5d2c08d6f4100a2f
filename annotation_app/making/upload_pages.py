"""Adding files to a study's folder, replacing, using and deleting them, and their pictures.

Files come in parts, each no larger than any request.
"""

from __future__ import annotations

from pathlib import Path

import flask
from flask import Blueprint, Response
from flask.typing import ResponseReturnValue
from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.core.problems import Refusal
from annotation_app.items.replaced_videos import asked_about
from annotation_app.making.added_files import LABELS, folder_of
from annotation_app.making.step_forms import use_file
from annotation_app.making.step_pages import opened_draft, opened_video
from annotation_app.store.audit import name_of, note
from annotation_app.store.installation import installation
from annotation_app.store.models import Study
from annotation_app.study_setup import uploads
from annotation_app.study_setup.own_videos import SUFFIXES, OwnVideo
from annotation_app.study_setup.prepared_videos import check_readable, part_of, thumbnail
from annotation_app.study_setup.rendered_study import FILES
from annotation_app.study_setup.study_drafts import StudyDraft, keep_draft
from annotation_app.web.who_asks import changed_by, refused, seen_by
from g3.errors import CorpusError

blueprint = Blueprint("making_uploads", __name__, url_prefix="/admin/studies")


@blueprint.errorhandler(Refusal)
def _refused(refusal: Refusal) -> ResponseReturnValue:
    if flask.request.endpoint == f"{blueprint.name}.upload":
        return flask.jsonify({"error": refusal.message}), refusal.status
    return refused(refusal)


@blueprint.post("/<name>/upload")
def upload(name: str) -> ResponseReturnValue:
    """Keep the next part of a file; once it is whole, look at it, and use it if nothing else is."""
    asked = flask.request.args
    with seen_by("admin") as (session, _):
        draft = opened_draft(session, name)
        folder, file = folder_of(draft), asked.get("file", "")
        offset, size = (asked.get(key, -1, type=int) for key in ("offset", "size"))
        is_replacing = asked.get("replace") == "yes"
        if is_replacing:
            _check_unasked(session, draft, folder / file)
    try:
        whole = uploads.add_part(
            folder,
            file,
            offset,
            flask.request.get_data(),
            size,
            check=_check,
            replacing=is_replacing,
        )
        if whole is not None and not is_replacing:
            _use_new(draft, whole)
    except uploads.ThereAlreadyError as error:
        return flask.jsonify({"error": str(error), "may_replace": True}), 409
    except CorpusError as error:
        raise Refusal(422, str(error)) from error
    except OSError as error:
        raise Refusal(507, f"The file can't be kept: {error.strerror}.") from error
    return flask.jsonify({"whole": whole is not None})


@blueprint.post("/<name>/upload/<file>")
def change(name: str, file: str) -> ResponseReturnValue:
    """Use an added file for something in the study, or delete it."""
    with changed_by("admin") as (session, admin):
        draft = opened_draft(session, name)
        found = _added(draft, file)
        action, value = flask.request.form.get("action", ""), dict(draft.value)
        if action in LABELS and action in uploads.uses(found):
            use_file(value, action, found, draft)
        elif action == "delete":
            _check_unasked(session, draft, found)
            for field in _fields_of(draft, found):
                if not draft.is_new:
                    raise Refusal(409, "The study uses this file. Choose another one first.")
                use_file(value, field, None, draft)
            found.unlink()
            note(session, name_of(admin), "deleted an added file", name, file=file)
        else:
            raise Refusal(422, "This file can't be used so.")
    keep_draft(installation().config.studies_folder, draft, value)
    return flask.redirect(flask.url_for("making.step", name=name, step_name="videos"), 303)


@blueprint.get("/<name>/upload/<file>")
def picture(name: str, file: str) -> Response:
    """Send a small picture of an added video or picture."""
    with seen_by("admin") as (session, _):
        draft = opened_draft(session, name)
    return _small(_added(draft, file))


@blueprint.get("/<name>/video/<int:number>/picture")
def video_picture(name: str, number: int) -> Response:
    """Send a small picture of one of a draft's videos."""
    _, item = opened_video(name, number)
    if isinstance(item, OwnVideo):
        return _small(item.file, item)
    return _small(item.folder / FILES["poster"])


def _small(file: Path, item: OwnVideo | None = None) -> Response:
    try:
        content = thumbnail(file, part_of(item) if item is not None else None)
    except (CorpusError, OSError) as error:
        raise Refusal(404, "There is no picture of this.") from error
    response = Response(content, mimetype="image/jpeg")
    if "v" in flask.request.args:  # else another video may have this address by then
        response.headers["Cache-Control"] = "private, max-age=3600"
    return response


def _added(draft: StudyDraft, file: str) -> Path:
    found = uploads.upload(folder_of(draft), file)
    if found is None:
        raise Refusal(404, "There is no such file.")
    return found


def _check_unasked(session: Session, draft: StudyDraft, file: Path) -> None:
    """Refuse to replace or delete a video that people were asked about."""
    study = session.scalars(select(Study).where(Study.name == draft.name)).first()
    if study is not None and (video := asked_about(session, study.id, file.resolve())):
        raise Refusal(409, f"People have been asked about the video {video}: it has to stay.")


def _fields_of(draft: StudyDraft, file: Path) -> list[str]:
    """Return the fields of a draft that name a file."""
    return [
        field
        for field in LABELS
        if draft.value.get(field)
        and (draft.file.parent / str(draft.value[field])).resolve() == file.resolve()
    ]


def _use_new(draft: StudyDraft, file: Path) -> None:
    """Use a new file for the first thing that it may be, unless something else is used for that."""
    value = dict(draft.value)
    may_be = uploads.uses(file)
    if may_be and not value.get(may_be[0]):
        use_file(value, may_be[0], file, draft)
    elif file.suffix.lower() in SUFFIXES and not value.get("videos"):
        use_file(value, "videos", file.parent, draft)
    if value != draft.value:
        keep_draft(installation().config.studies_folder, draft, value)


def _check(file: Path) -> None:
    """Refuse a video that browsers can't play."""
    if file.suffix.lower() in SUFFIXES:
        check_readable([OwnVideo(file.stem, file, {})])
