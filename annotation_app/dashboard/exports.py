"""A study's answers as files, for people and for programs."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping

import flask
from flask import Response
from sqlalchemy.orm import Session

from annotation_app.core.problems import Refusal
from annotation_app.export import answer_tables
from annotation_app.export.corpus_export import export_corpus
from annotation_app.store.audit import note
from annotation_app.store.database import reading, transaction
from annotation_app.store.installation import installation
from annotation_app.store.models import Study
from annotation_app.web.readers import required_reader
from annotation_app.work.handing_out import find_study
from corpus_tools.corpus.corpus_writing import corpus_files
from corpus_tools.exporters.slu_core import slu_core_files
from g3.errors import CorpusError

FOLDERS = {"corpus": corpus_files, "slu-core": slu_core_files}


def export_response(study_name: str, form: str) -> Response:
    """A file, for whoever may have it; the audit trail notes who had it.

    Raises
    ------
    Refusal
        If they may not, there is no such study or form, or something for it isn't installed.
    """
    with reading(installation().engine) as session:
        reader = required_reader(session, "adjudicator")
        study = find_study(session, study_name)
        try:
            content, name, media_type = _exported(session, study, form)
        except CorpusError as error:  # something isn't installed
            raise Refusal(501, str(error)) from error
    with transaction(installation().engine) as session:
        note(session, reader, "exported", study.name, format=form)
    response = Response(content, mimetype=media_type)
    response.headers["Content-Disposition"] = f'attachment; filename="{name}"'
    return response


def _exported(session: Session, study: Study, form: str) -> tuple[bytes, str, str]:
    table = answer_tables.TABLES.get(form)
    if table is not None:
        write = table.write
        if flask.request.args.get("excluded") == "yes":
            write = answer_tables.WITH_EXCLUDED.get(form, write)
        return write(session, study), f"{study.name}.{form}", table.media_type
    if form in FOLDERS:
        files = FOLDERS[form](export_corpus(session, study))
        return _zipped(study.name, files), f"{study.name}.zip", "application/zip"
    raise Refusal(404, "There is no such export.")


def _zipped(folder: str, files: Mapping[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(f"{folder}/{name}", content)
    return buffer.getvalue()
