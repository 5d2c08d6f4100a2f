"""The audit trail as a page, for admins."""

from __future__ import annotations

import datetime

import flask
from flask import Blueprint

from annotation_app.core.problems import Refusal
from annotation_app.dashboard.answer_browsing import read_before
from annotation_app.store.audit import actions, trail
from annotation_app.web.who_asks import refused, seen_by

PAGE = 50

blueprint = Blueprint("audit_pages", __name__, url_prefix="/admin")
blueprint.register_error_handler(Refusal, refused)


@blueprint.get("/audit")
def audit() -> str:
    """Who did what and when, newest first."""
    asked = flask.request.args
    person, action = asked.get("person", "").strip(), asked.get("action", "")
    with seen_by("admin") as (session, admin):
        found = trail(
            session,
            person=person,
            action=action,
            before=read_before(asked),
            most=PAGE + 1,
        )
        return flask.render_template(
            "dashboard/audit.html",
            person=admin,
            entries=found[:PAGE],
            older=found[PAGE - 1].id if len(found) > PAGE else None,
            actions=actions(session),
            asked_person=person,
            asked_action=action,
        )


@blueprint.app_template_filter("moment")
def moment(at: float | None) -> str:
    """A time for people, in UTC, as the server can't know where they are."""
    if at is None:
        return "never"
    try:
        found = datetime.datetime.fromtimestamp(at, datetime.timezone.utc)
    except (OverflowError, OSError, ValueError):  # a clock that was far out
        return "?"
    return found.strftime("%Y-%m-%d %H:%M UTC")
