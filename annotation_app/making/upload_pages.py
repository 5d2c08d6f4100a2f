"""Adding files to a study's folder: they come in parts, each no larger than any request."""

from __future__ import annotations

import os
from pathlib import Path

import flask
from flask import Blueprint, Response
from flask.typing import ResponseReturnValue

from annotation_app.core.problems import Refusal
from annotation_app.making.step_pages import opened_draft
from annotation_app.store.installation import installation
from annotation_app.study_setup.own_videos import SUFFIXES, OwnVideo
from annotation_app.study_setup.prepared_videos import check_readable
from annotation_app.study_setup.server_folders import add_part
from annotation_app.study_setup.study_drafts import keep_draft
from annotation_app.web.who_asks import seen_by
from g3.errors import CorpusError

blueprint = Blueprint("making_uploads", __name__, url_prefix="/admin/studies")


@blueprint.errorhandler(Refusal)
def _refused(refusal: Refusal) -> ResponseReturnValue:
    return flask.jsonify({"error": refusal.message}), refusal.status


@blueprint.post("/<name>/upload")
def upload(name: str) -> Response:
    """Keep the next part of a file; look at a video once it is whole."""
    config, asked = installation().config, flask.request.args
    with seen_by("admin") as (session, _):
        draft = opened_draft(session, name)
    folder = config.studies_folder / f"{draft.name}-videos"
    offset, size = (asked.get(key, -1, type=int) for key in ("offset", "size"))
    try:
        whole = add_part(folder, asked.get("file", ""), offset, flask.request.get_data(), size)
        if whole is not None:
            _check(whole)
            if not draft.value.get("videos"):
                named = os.path.relpath(folder, draft.file.parent)
                keep_draft(config.studies_folder, draft, {**draft.value, "videos": named})
    except CorpusError as error:
        raise Refusal(422, str(error)) from error
    except OSError as error:
        raise Refusal(507, f"The file can't be kept: {error.strerror}.") from error
    return flask.jsonify({"whole": whole is not None})


def _check(file: Path) -> None:
    """Take a video away again that browsers can't play."""
    if file.suffix.lower() in SUFFIXES:
        try:
            check_readable([OwnVideo(file.stem, file, {})])
        except CorpusError:
            file.unlink()
            raise
