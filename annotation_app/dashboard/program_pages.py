"""Pages on which admins let other programs read, by tokens, and inform them, by webhooks."""

from __future__ import annotations

import flask
from flask import Blueprint
from flask.typing import ResponseReturnValue
from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.core.problems import Refusal
from annotation_app.people import api_tokens
from annotation_app.people.api_tokens import MOST_DAYS
from annotation_app.store.audit import name_of, note
from annotation_app.store.installation import installation, now
from annotation_app.store.models import Person, Study
from annotation_app.store.program_models import Webhook
from annotation_app.web.public_links import public
from annotation_app.web.who_asks import changed_by, refused, refused_on, seen_by
from annotation_app.work import webhooks
from annotation_app.work.handing_out import find_study

blueprint = Blueprint("program_pages", __name__, url_prefix="/admin")
blueprint.register_error_handler(Refusal, refused)

MOST = 30
"""How many messages a webhook's page shows."""


def _tokens_page(session: Session, admin: Person, problem: str = "") -> str:
    return flask.render_template(
        "dashboard/tokens.html",
        person=admin,
        tokens=api_tokens.tokens(session),
        at=now(),
        days=api_tokens.DAYS,
        problem=problem,
        form=flask.request.form,
    )


@blueprint.get("/tokens")
def tokens() -> str:
    """All tokens, without what programs send."""
    with seen_by("admin") as (session, admin):
        return _tokens_page(session, admin)


@blueprint.post("/tokens")
@refused_on(_tokens_page)
def make() -> ResponseReturnValue:
    """Make a token, and show it once."""
    form = flask.request.form
    days, name = form.get("days", ""), form.get("name", "").strip()
    with changed_by("admin") as (session, admin):
        if not days.isascii() or not days.isdigit() or not 1 <= int(days[:9]) <= MOST_DAYS:
            raise Refusal(422, f"Use 1 to {MOST_DAYS} days.")
        token = api_tokens.make_token(session, name, int(days), actor=name_of(admin))
        return flask.render_template(
            "dashboard/token.html",
            person=admin,
            name=name,
            shown=token,
            address=public("dashboard_interface.studies"),
        )


@blueprint.get("/tokens/revoke")
def confirm_revocation() -> str:
    """Whether a token is really to be revoked."""
    with seen_by("admin") as (session, admin):
        name = flask.request.args.get("name", "")
        if name not in [token.name for token in api_tokens.tokens(session)]:
            raise Refusal(404, "There is no such token.")
        return flask.render_template(
            "dashboard/token_revoke.html",
            person=admin,
            name=name,
            back=flask.url_for("program_pages.tokens"),
        )


@blueprint.post("/tokens/revoke")
def revoke() -> ResponseReturnValue:
    """Let a token read nothing any more."""
    with changed_by("admin") as (session, admin):
        api_tokens.revoke_token(session, flask.request.form.get("name", ""), actor=name_of(admin))
    return flask.redirect(flask.url_for("program_pages.tokens"), 303)


def _webhooks_page(session: Session, admin: Person, problem: str = "") -> str:
    return flask.render_template(
        "dashboard/webhooks.html",
        person=admin,
        hooks=webhooks.webhook_states(session),
        studies=session.scalars(select(Study.name).order_by(Study.name)).all(),
        problem=problem,
        form=flask.request.form,
    )


@blueprint.get("/webhooks")
def all_webhooks() -> str:
    """All webhooks, and a form to add one."""
    with seen_by("admin") as (session, admin):
        return _webhooks_page(session, admin)


@blueprint.post("/webhooks")
@refused_on(_webhooks_page)
def add() -> ResponseReturnValue:
    """Add a webhook, and show its secret once. Private addresses need the command line."""
    form = flask.request.form
    url, links_to = form.get("url", "").strip(), flask.request.url_root.rstrip("/")
    with seen_by("admin") as (session, _):
        find_study(session, form.get("study", ""))
    webhooks.check_webhook(url, links_to=links_to)  # takes a while: nobody waits for it
    with changed_by("admin") as (session, admin):
        made = webhooks.add_webhook(
            session,
            find_study(session, form.get("study", "")),
            url,
            links_to=links_to,
            with_answers="with_answers" in form,
            actor=name_of(admin),
        )
        secret = webhooks.written_secret(installation().config.secret_key, made.id)
        return flask.render_template(
            "dashboard/webhook_secret.html", person=admin, hook=made, shown=secret
        )


@blueprint.get("/webhooks/<webhook_id>")
def one(webhook_id: str) -> str:
    """What became of a webhook's messages."""
    with seen_by("admin") as (session, admin):
        return _webhook_page(session, admin, webhook_id)


@blueprint.post("/webhooks/<webhook_id>/test")
def test(webhook_id: str) -> str:
    """Send a message at once, and say whether it arrived."""
    with changed_by("admin") as (session, admin):
        hook, study = _find(session, webhook_id)
        note(session, name_of(admin), "tested a webhook", study, webhook=webhook_id)
        session.flush()
        session.expunge(hook)
    problem = webhooks.send_test(hook, study, installation().config.secret_key)
    with seen_by("admin") as (session, admin):
        return _webhook_page(
            session,
            admin,
            webhook_id,
            arrived=not problem,
            problem=f"The test didn’t arrive: {problem}." if problem else "",
        )


@blueprint.post("/webhooks/<webhook_id>/again")
def again(webhook_id: str) -> ResponseReturnValue:
    """Have what wasn't sent yet tried at once."""
    with changed_by("admin") as (session, admin):
        _, study = _find(session, webhook_id)
        webhooks.try_again(session, now=now(), webhook_id=webhook_id)
        note(session, name_of(admin), "sent messages again", study, webhook=webhook_id)
    return flask.redirect(flask.url_for("program_pages.one", webhook_id=webhook_id), 303)


@blueprint.get("/webhooks/<webhook_id>/remove")
def confirm_removal(webhook_id: str) -> str:
    """Whether a webhook is really to be removed."""
    with seen_by("admin") as (session, admin):
        hook, study = _find(session, webhook_id)
        return flask.render_template(
            "dashboard/webhook_remove.html",
            person=admin,
            hook=hook,
            of_study=study,
            back=flask.url_for("program_pages.one", webhook_id=hook.id),
        )


@blueprint.post("/webhooks/<webhook_id>/remove")
def remove(webhook_id: str) -> ResponseReturnValue:
    """Tell an address nothing any more."""
    with changed_by("admin") as (session, admin):
        webhooks.remove_webhook(session, webhook_id, actor=name_of(admin))
    return flask.redirect(flask.url_for("program_pages.all_webhooks"), 303)


def _find(session: Session, webhook_id: str) -> tuple[Webhook, str]:
    found = session.get(Webhook, webhook_id)
    if found is None:
        raise Refusal(404, "There is no such webhook.")
    return found, session.get_one(Study, found.study_id).name


def _webhook_page(
    session: Session, admin: Person, webhook_id: str, *, arrived: bool = False, problem: str = ""
) -> str:
    _find(session, webhook_id)
    states = webhooks.webhook_states(session)
    return flask.render_template(
        "dashboard/webhook.html",
        person=admin,
        hook=next(state for state in states if state.webhook == webhook_id),
        messages=webhooks.last_messages(session, webhook_id, MOST),
        most=MOST,
        arrived=arrived,
        problem=problem,
    )
