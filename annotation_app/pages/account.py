"""Signing in and out, and the making of the first admin."""

from __future__ import annotations

import flask
from flask import Blueprint
from flask.typing import ResponseReturnValue

from annotation_app.database import reading, transaction
from annotation_app.installation import installation
from annotation_app.limits import limited, sign_ins
from annotation_app.people import find_login, sign_in, sign_out, use_admin_token
from annotation_app.problems import Refusal

blueprint = Blueprint("account", __name__)


@blueprint.get("/login")
def login() -> str:
    """The form to sign in."""
    return flask.render_template("login.html", back=_local(flask.request.args.get("next", "")))


@blueprint.post("/login")
@limited(sign_ins)
def sign_in_() -> ResponseReturnValue:
    """Sign in, and go back to where somebody wanted to go."""
    form = flask.request.form
    back = _local(form.get("next", ""))
    with reading(installation().engine) as session:
        person = find_login(session, form.get("login", ""), form.get("password", ""))
    if person is None:
        problem = "There is no such login with this password. Check both."
        page = flask.render_template(
            "login.html", back=back, problem=problem, login=form.get("login", "")[:100]
        )
        return page, 422
    sign_in(person)
    return flask.redirect(back, 303)


@blueprint.post("/logout")
def logout() -> ResponseReturnValue:
    """Sign out."""
    sign_out()
    return flask.redirect("/", 303)


@blueprint.get("/setup/<token>")
def setup(token: str) -> str:
    """The form for the first admin. Only sending it tells whether the token is right."""
    return flask.render_template("setup.html", token=token)


@blueprint.post("/setup/<token>")
@limited(sign_ins)
def make_admin(token: str) -> ResponseReturnValue:
    """Make the first admin, once."""
    form = flask.request.form
    try:
        if form.get("password") != form.get("again"):
            raise Refusal(422, "The two passwords differ. Type the same one twice.")
        with transaction(installation().engine) as session:
            person = use_admin_token(
                session, token, form.get("login", ""), form.get("password", "")
            )
    except Refusal as refusal:
        page = flask.render_template(
            "setup.html", token=token, problem=refusal.message, login=form.get("login", "")[:100]
        )
        return page, refusal.status
    sign_in(person)
    return flask.redirect("/", 303)


def _local(address: str) -> str:
    """A place of this app to go back to, whatever somebody has put into a link."""
    is_local = address.startswith("/") and address[1:2] not in ("/", "\\") and address.isprintable()
    return address if is_local else "/"
