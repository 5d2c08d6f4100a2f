"""Pages on which admins let other programs read, by tokens."""

from __future__ import annotations

import flask
from flask import Blueprint
from flask.typing import ResponseReturnValue
from sqlalchemy.orm import Session

from annotation_app.core.problems import Refusal
from annotation_app.people import api_tokens
from annotation_app.people.api_tokens import MOST_DAYS
from annotation_app.store.audit import name_of
from annotation_app.store.installation import now
from annotation_app.store.models import Person
from annotation_app.web.public_links import public
from annotation_app.web.who_asks import changed_by, refused, refused_on, seen_by

blueprint = Blueprint("program_pages", __name__, url_prefix="/admin")
blueprint.register_error_handler(Refusal, refused)


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
    """Show all tokens, but not their secrets."""
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
    """Ask for confirmation that a token is revoked."""
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
