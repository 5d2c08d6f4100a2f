"""Making the Flask app."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Sequence
from urllib.parse import urlsplit

import flask
import msgspec
from flask import Flask, Response
from flask_wtf.csrf import CSRFProtect
from sqlalchemy import Engine
from werkzeug.exceptions import HTTPException
from werkzeug.middleware.proxy_fix import ProxyFix

from annotation_app.core.config import Config
from annotation_app.core.languages import N_, gettext
from annotation_app.core.problems import Refusal
from annotation_app.crowds import crowd_pages as crowds
from annotation_app.dashboard import (
    adjudication_pages,
    answer_pages,
    answers_api,
    assigning_pages,
    login_admin,
)
from annotation_app.dashboard import dashboard_api as interface
from annotation_app.dashboard import dashboard_pages as dashboard
from annotation_app.items import media
from annotation_app.making import BLUEPRINTS as MAKING
from annotation_app.pages import BLUEPRINTS
from annotation_app.people.browser_sessions import LONGEST, SessionCookies, wants_json
from annotation_app.serving import openapi
from annotation_app.store.database import open_database
from annotation_app.store.installation import Installation, install, installation
from annotation_app.store.outages import ADVICE, AGAIN_S, TITLE, Outage, outage_of
from annotation_app.store.salt import installation_salt
from annotation_app.studies.study_file import StudyConfig
from annotation_app.tasks.task_registry import tasks
from annotation_app.trying import try_pages as trying
from annotation_app.trying.attempt import Shown
from annotation_app.trying.attempt_queue import Attempts
from annotation_app.trying.start_scene import Scene
from annotation_app.web import api
from annotation_app.web.limits import limiter
from annotation_app.web.page_language import install as install_language
from annotation_app.web.public_links import only_paths
from annotation_app.web.who_asks import error_page
from corpus_tools.corpus.corpus_records import (
    AnnotationRecord,
    CommandRecord,
    ContextRecord,
    JudgmentRecord,
    Manifest,
)
from corpus_tools.logs.channels import CHANNELS

log = logging.getLogger(__name__)


def create_app(config: Config, engine: Engine | None = None) -> Flask:
    """Return the app, for any WSGI server.

    The database may be open already; its tables must be there
    (:func:`annotation_app.store.schema.migrate`).
    """
    learn_types()
    app = Flask("annotation_app")
    app.session_interface = SessionCookies(config.idle_hours * 3600)
    app.config.update(
        SECRET_KEY=config.secret_key,
        MAX_CONTENT_LENGTH=config.max_body_bytes,
        MAX_FORM_MEMORY_SIZE=config.max_body_bytes,
        PERMANENT_SESSION_LIFETIME=LONGEST,
        SESSION_COOKIE_HTTPONLY=True,
        SESSION_COOKIE_SECURE=config.https,
        SESSION_COOKIE_SAMESITE="None" if _is_framed(config) else "Lax",
        SESSION_COOKIE_PARTITIONED=_is_framed(config),
        # A page may stay open for days. The token is bound to the session all the same.
        WTF_CSRF_TIME_LIMIT=None,
        # There is no Referer to look at: pages are sent with "no-referrer".
        WTF_CSRF_SSL_STRICT=False,
    )
    engine = engine or open_database(config.database)
    counter = limiter(config.limits_storage) if config.rate_limits else None
    install(app, Installation(config, engine, installation_salt(engine, config), counter))
    Attempts(config.instance, config.model).install(app)
    CSRFProtect(app)
    of_dashboard = (
        dashboard,
        adjudication_pages,
        answer_pages,
        assigning_pages,
        answers_api,
        login_admin,
        interface,
    )
    modules = (api, openapi, media, crowds, *of_dashboard, trying)
    of_tasks = (task.blueprint for task in tasks() if task.blueprint is not None)
    for blueprint in (*(module.blueprint for module in modules), *BLUEPRINTS, *MAKING, *of_tasks):
        app.register_blueprint(blueprint)
    researchers = (*(module.blueprint for module in (*of_dashboard, trying)), *MAKING)
    install_language(app, {blueprint.name for blueprint in researchers})
    app.register_error_handler(Refusal, _refused)
    app.register_error_handler(HTTPException, _http_error)
    app.register_error_handler(Exception, _failed)
    policy = _content_security_policy(config)

    @app.before_request
    def refuse_nul() -> None:
        # No database keeps it, so that nothing here has such a name.
        if "\0" in flask.request.path:
            flask.abort(404)

    @app.after_request
    def secure(response: Response) -> Response:
        if flask.request.method != "GET" and response.status_code < 400:
            installation().outages.worked()
        response.headers["Content-Security-Policy"] = policy
        response.headers["X-Content-Type-Options"] = "nosniff"
        response.headers["Referrer-Policy"] = "no-referrer"
        response.headers["Cross-Origin-Opener-Policy"] = "same-origin"
        response.headers.setdefault("Cache-Control", "no-store")
        if config.https:
            response.headers["Strict-Transport-Security"] = "max-age=31536000"
        return response

    if config.proxies:
        n = config.proxies
        app.wsgi_app = ProxyFix(  # type: ignore[method-assign]
            only_paths(app.wsgi_app), x_for=n, x_proto=n, x_host=n, x_prefix=n
        )
    return app


def record_types() -> Iterable[type]:
    """Return all types that requests may need."""
    of_corpora = (AnnotationRecord, CommandRecord, ContextRecord, JudgmentRecord, Manifest)
    of_logs = (channel.message for channel in CHANNELS.values())
    answers = (task.answer for task in tasks())
    return (StudyConfig, Shown, Scene, *of_corpora, *of_logs, *api.REQUESTS.values(), *answers)


def learn_types() -> None:
    """Have msgspec look at each type now.

    It does so when a type is first used. If two threads do that at the same time, the process may
    die of it (msgspec 0.22). A server that was started again under load did.
    """
    for record_type in record_types():
        msgspec.json.Decoder(record_type)


def _is_framed(config: Config) -> bool:
    # Browsers keep such cookies only over HTTPS.
    return bool(config.frame_ancestors) and config.https


def _content_security_policy(config: Config) -> str:
    elsewhere = urlsplit(config.media_url)
    media = f"'self' {elsewhere.scheme}://{elsewhere.netloc}" if elsewhere.netloc else "'self'"
    parts = {
        "default-src": "'none'",
        "script-src": "'self'",
        "style-src": "'self'",
        "img-src": media,
        "media-src": media,
        "font-src": "'self'",
        "connect-src": "'self'",
        "manifest-src": "'self'",
        "base-uri": "'none'",
        "form-action": " ".join(("'self'", *config.form_targets)),
        "frame-ancestors": " ".join(config.frame_ancestors) or "'none'",
    }
    return "; ".join(f"{name} {value}" for name, value in parts.items())


def _refused(refusal: Refusal) -> Response:
    problems = [{"field": p.field, "message": p.message} for p in refusal.problems]
    return _failure(refusal.status, refusal.message, problems=problems)


def _http_error(error: HTTPException) -> Response:
    status = error.code or 500
    if error.response is not None:
        return flask.make_response(error.response)
    response = _failure(status, gettext(_MESSAGES.get(status, error.description or error.name)))
    response.headers.extend(
        (name, value)
        for name, value in error.get_headers()
        if name not in ("Content-Type", "Content-Length")
    )
    return response


def _failed(error: Exception) -> Response:
    outage = outage_of(error)
    if outage is not None:
        return _unavailable(outage)
    # What people sent is in no message: the traceback has lines of the program only.
    log.exception("a request to %s failed", flask.request.url_rule, exc_info=error)
    return _failure(500, gettext("Something went wrong here."), gettext(_TYPED))


def _unavailable(outage: Outage) -> Response:
    installation().outages.failed(outage)
    response = _failure(503, gettext(TITLE), gettext(ADVICE))
    response.headers["Retry-After"] = str(AGAIN_S)
    return response


def _failure(
    status: int, message: str, advice: str = "", problems: Sequence[dict[str, str]] = ()
) -> Response:
    """Return an error: as a page for people, as JSON for scripts and programs."""
    if wants_json():
        reply = {"error": f"{message} {advice}" if advice else message}
        return flask.make_response(reply | ({"problems": problems} if problems else {}), status)
    return flask.make_response(error_page(status, message, advice))


_TYPED = N_("Nothing that you typed is lost: try again in a minute.")


_MESSAGES = {
    400: N_("The request can't be read. Load the page again; what you typed is kept."),
    404: N_("There is no such page."),
    405: N_("This can't be done here."),
    413: N_("This is too large to be sent."),
    429: N_("That was a bit fast. Wait a minute and try again; what you typed is kept."),
}
