"""A study's answers as files, for people and for programs."""

from __future__ import annotations

import tempfile
import weakref
import zipfile
from collections.abc import Mapping
from typing import IO

import flask
from flask import Response
from sqlalchemy.orm import Session
from werkzeug.wsgi import wrap_file

from annotation_app.core.problems import Refusal
from annotation_app.export import answer_tables
from annotation_app.export.corpus_export import export_corpus
from annotation_app.store.audit import note
from annotation_app.store.database import reading, transaction
from annotation_app.store.installation import installation
from annotation_app.store.models import Study
from annotation_app.web.who_asks import required_reader
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
    with reading(installation().engine, one_state=True) as session:
        reader = required_reader(session, "adjudicator")
        study = find_study(session, study_name)
        # Sent when it is whole: a table that breaks off looks as if there were no more answers.
        file = tempfile.TemporaryFile()  # noqa: SIM115 - the reply closes it
        try:
            name, media_type = _write(session, study, form, file)
        except BaseException as error:
            file.close()
            if isinstance(error, CorpusError):  # something isn't installed
                raise Refusal(501, str(error)) from error
            raise
    with transaction(installation().engine) as session:
        note(session, reader, "exported", study.name, format=form)
    # The server sends it from the disk, so that a slow reader keeps no thread.
    pieces = wrap_file(flask.request.environ, file)
    weakref.finalize(pieces, file.close)  # also where nobody reads them to the end
    response = Response(pieces, mimetype=media_type, direct_passthrough=True)
    response.content_length = file.tell()
    file.seek(0)
    response.headers["Content-Disposition"] = f'attachment; filename="{name}"'
    return response


def _write(session: Session, study: Study, form: str, file: IO[bytes]) -> tuple[str, str]:
    """Write an export; what the file is called, and its type."""
    table = answer_tables.TABLES.get(form)
    if table is not None:
        write = table.write
        if flask.request.args.get("excluded") == "yes":
            write = answer_tables.WITH_EXCLUDED.get(form, write)
        write(session, study, file)
        return f"{study.name}.{form}", table.media_type
    if form in FOLDERS:
        files = FOLDERS[form](export_corpus(session, study))
        _zip(file, study.name, files)
        return f"{study.name}.zip", "application/zip"
    raise Refusal(404, "There is no such export.")


def _zip(file: IO[bytes], folder: str, files: Mapping[str, bytes]) -> None:
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(f"{folder}/{name}", content)
