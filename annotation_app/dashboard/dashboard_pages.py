"""The dashboard's pages, for people with a login, and a study's answers as files."""

from __future__ import annotations

import tempfile
import weakref
import zipfile
from typing import IO, Any

import flask
from flask import Blueprint, Response
from flask.typing import ResponseReturnValue
from sqlalchemy import select
from sqlalchemy.orm import Session
from werkzeug.wsgi import wrap_file

from annotation_app.core.problems import Refusal
from annotation_app.dashboard import adjudication_queue as queue
from annotation_app.dashboard import dashboard_charts as charts
from annotation_app.dashboard.answer_browsing import open_reports
from annotation_app.dashboard.consensus import (
    Consensus,
    Disagreement,
    consensus,
    disagreements,
)
from annotation_app.dashboard.study_statistics import (
    at_work,
    collected,
    durations,
    forecast,
    histories,
    model_errors,
    progress_by_task,
    progress_by_video,
    suggestion_uses,
)
from annotation_app.dashboard.workers import workers
from annotation_app.export import answer_tables
from annotation_app.export.corpus_export import export_corpus
from annotation_app.people import accounts
from annotation_app.people.participants import RANKS, subject_of
from annotation_app.people.person_names import shown_name
from annotation_app.store.audit import name_of, note
from annotation_app.store.database import reading, transaction
from annotation_app.store.installation import installation, now
from annotation_app.store.models import Answer, Person, Study
from annotation_app.tasks.agreement import CLAUSE_TYPE, FEWEST_ITEMS, WORDS
from annotation_app.tasks.task_registry import task_of, tasks
from annotation_app.web.public_links import is_of_this_computer, public
from annotation_app.web.who_asks import changed_by, refused, required_reader, seen_by
from annotation_app.work.handing_out import find_study
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.estimate import REASONS
from corpus_tools.exporters.slu_core import slu_core_files
from corpus_tools.exporters.treebank_files import treebank_files
from g3.errors import CorpusError

FOLDERS = {"corpus": Corpus.files, "treebank": treebank_files, "slu-core": slu_core_files}

blueprint = Blueprint(
    "dashboard",
    __name__,
    url_prefix="/dashboard",
    template_folder="templates",
    static_folder="static",
)
blueprint.register_error_handler(Refusal, refused)
blueprint.add_app_template_filter(charts.span_words, "span")
blueprint.add_app_template_test(is_of_this_computer, "of_this_computer")


@blueprint.get("/")
def studies() -> str:
    """Show all studies."""
    with seen_by("annotator") as (session, person):
        found = session.scalars(select(Study).order_by(Study.name)).all()
        return _page("studies.html", person, studies=found)


@blueprint.get("/<study_name>")
def overview(study_name: str) -> str:
    """Show a study's progress. Names of videos and people's work are for adjudicators."""
    with seen_by("annotator", one_state=True) as (session, person):
        study = find_study(session, study_name)
        moment = now()
        by_video = progress_by_video(session, study.id, now=moment)
        by_task = progress_by_task(by_video)
        sees_all = RANKS[person.role] >= RANKS["adjudicator"]
        agreed = consensus(session, study.id) if sees_all else Consensus([], [])
        times = durations(session, study.id)
        came = histories(session, study.id, now=moment)
        people = workers(session, study.id) if sees_all else []
        return _page(
            "overview.html",
            person,
            study=study,
            now=moment,
            by_task=by_task,
            by_video=by_video if sees_all else [],
            durations=times,
            forecast=forecast(session, study.id, by_task, times, now=moment),
            histories=came,
            charts={
                "history": charts.history_chart(came, {p.task: p.wanted for p in by_task}),
                "agreement": charts.agreement_chart(agreed.over_time),
            },
            collected=collected(session, study.id),
            suggestion_uses=suggestion_uses(session, study.id),
            model_errors=model_errors(session, study.id) if sees_all else [],
            counts=[task.counts for task in tasks() if task.counts is not None],
            agreement=agreed.overall,
            over_time=agreed.over_time,
            fewest=FEWEST_ITEMS,
            reasons=REASONS,
            working=at_work(session, study.id, now=moment) if sees_all else [],
            flagged=[worker for worker in people if worker.reasons and not worker.is_blocked],
            reports=open_reports(session, study.id) if sees_all else 0,
            disputes=queue.disputes(session, study.id) if sees_all else [],
            sees_all=sees_all,
            subject_of=subject_of,
            shown_name=shown_name,
            link=public("entrance.study_page", study_name=study.name),
        )


@blueprint.get("/<study_name>/exports")
def exports(study_name: str) -> str:
    """Show all files that a study's answers can be saved as."""
    with seen_by("adjudicator") as (session, person):
        study = find_study(session, study_name)
        answered = select(Answer.id).where(Answer.study_id == study.id).limit(1)
        return _page(
            "exports.html",
            person,
            study=study,
            answers=session.scalar(answered) is not None,
            tables=answer_tables.tables_of(session, study),
            with_excluded=answer_tables.WITH_EXCLUDED,
        )


@blueprint.get("/<study_name>/disagreements", endpoint="disagreements")
def disagreements_page(study_name: str) -> str:
    """Show the most frequent disagreements, and where to look at them."""
    with seen_by("adjudicator") as (session, person):
        study = find_study(session, study_name)
        found = disagreements(session, study.id)
        linked = [(one, _link(study.name, one)) for one in found]
        return _page("disagreements.html", person, study=study, found=linked, fewest=FEWEST_ITEMS)


def _link(study_name: str, one: Disagreement) -> str:
    if one.kind == "item" and task_of(one.task).adjudication is not None:
        return flask.url_for("adjudication.dispute", study_name=study_name, item_id=one.what)
    asked: dict[str, Any] = {"study_name": study_name, "task": one.task}
    if one.kind == WORDS:
        asked["text"] = one.what
    elif one.kind == "item":
        asked |= {"text": one.command, "video": one.video}
    elif one.kind not in ("task", CLAUSE_TYPE):
        asked["video"] = one.video
    return flask.url_for("answer_pages.answers", **asked)


@blueprint.get("/<study_name>/people")
def people(study_name: str) -> str:
    """Show everybody who has answered."""
    with seen_by("adjudicator", one_state=True) as (session, person):
        study = find_study(session, study_name)
        everybody = workers(session, study.id, weighed=True)
        return _page("people.html", person, study=study, workers=everybody)


@blueprint.get("/<study_name>/people/<person_id>")
def confirm_block(study_name: str, person_id: str) -> str:
    """Ask for confirmation that somebody gets no more items."""
    with seen_by("admin") as (session, admin):
        study = find_study(session, study_name)
        found = _person(session, person_id)
        return _page(
            "block.html",
            admin,
            study=study,
            name=shown_name(found),
            about="They get no more items, in any study. What they have answered stays, and what "
            "they have begun they can still send. You can unblock them.",
            back=flask.url_for("dashboard.people", study_name=study.name),
        )


@blueprint.post("/<study_name>/people/<person_id>")
def block(study_name: str, person_id: str) -> ResponseReturnValue:
    """Give somebody no more items, or items again."""
    with changed_by("admin") as (session, admin):
        find_study(session, study_name)
        person = _person(session, person_id)
        wanted = flask.request.form.get("block") == "yes"
        change = accounts.block if wanted else accounts.unblock
        change(session, person, actor=name_of(admin))
    return flask.redirect(flask.url_for("dashboard.people", study_name=study_name), 303)


@blueprint.get("/<study_name>/export/<form>")
def export(study_name: str, form: str) -> Response:
    """Export all answers as they are, or the corpus made of them."""
    return export_response(study_name, form)


def export_response(study_name: str, form: str) -> Response:
    """Return a file for an entitled reader; the audit trail notes the reader.

    Refused if they may not, there is no such study or form, or something for it isn't installed.
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
        excluded = flask.request.args.get("excluded") == "yes"
        if excluded:
            write = answer_tables.WITH_EXCLUDED.get(form, write)
        write(session, study, file)
        return answer_tables.file_name(study.name, form, excluded=excluded), table.media_type
    if form in FOLDERS:
        files = FOLDERS[form](export_corpus(session, study))
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, content in files.items():
                archive.writestr(f"{study.name}/{name}", content)
        return f"{study.name}-{form}.zip", "application/zip"
    raise Refusal(404, "There is no such export.")


def _person(session: Session, person_id: str) -> Person:
    person = session.get(Person, person_id)
    if person is None:
        raise Refusal(404, "There is no such person.")
    return person


def _page(template: str, person: Person, **values: object) -> str:
    return flask.render_template(f"dashboard/{template}", person=person, **values)
