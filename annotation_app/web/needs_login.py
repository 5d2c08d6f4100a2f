"""The answer to people who may not see a page that needs a login."""

from __future__ import annotations

import flask
from flask.typing import ResponseReturnValue

from annotation_app.core.problems import Refusal
from g3.errors import CorpusError


def sign_in_page() -> ResponseReturnValue:
    """Off to sign in, and back here."""
    return flask.redirect(flask.url_for("account.login", next=flask.request.path))


def cannot_be_done(error: CorpusError) -> ResponseReturnValue:
    """What is wrong with a file that can't be read or written."""
    return refused(Refusal(422, f"This can't be done: {error}."))


def refused(refusal: Refusal) -> ResponseReturnValue:
    """Off to sign in and back, or the reason why not."""
    if refusal.status == 401 and flask.request.method == "GET":
        return sign_in_page()
    page = flask.render_template(
        "error.html",
        status=refusal.status,
        message=refusal.message,
        to_sign_in=refusal.status == 401,
    )
    return page, refusal.status
