"""Signing in and out, links that make logins, and everybody's own account."""

from __future__ import annotations

import math

import flask
from flask import Blueprint
from flask.typing import ResponseReturnValue
from sqlalchemy.orm import Session

from annotation_app.core.languages import N_, gettext, ngettext
from annotation_app.core.problems import Refusal
from annotation_app.people import accounts, failed_sign_ins
from annotation_app.people.account_links import read_link, use_link
from annotation_app.people.browser_sessions import (
    current_person,
    end_sessions,
    had_login,
    required_person,
    sign_in,
    sign_out,
)
from annotation_app.store.audit import name_of, note
from annotation_app.store.database import reading, transaction
from annotation_app.store.installation import installation, now
from annotation_app.store.models import Person
from annotation_app.web.limits import limited, sign_ins
from annotation_app.web.public_links import here
from annotation_app.web.who_asks import refused

blueprint = Blueprint("account", __name__)
blueprint.register_error_handler(Refusal, refused)

WRONG = N_("There is no such login with this password. Check both.")
BLOCKED = N_("Your login has been blocked. Ask the people who run the study.")
DIFFER = N_("The two passwords differ. Type the same one twice.")


@blueprint.get("/login")
def login() -> str:
    """Show the form to sign in."""
    with reading(installation().engine) as session:
        is_ended = had_login() and current_person(session) is None
    return flask.render_template(
        "login.html",
        back=_local(flask.request.args.get("next", "")),
        is_signed_out="signed_out" in flask.request.args,
        is_ended=is_ended,
    )


@blueprint.post("/login")
@limited(sign_ins, by_address=True)
def sign_in_() -> ResponseReturnValue:
    """Sign in, and go back to where somebody wanted to go."""
    form = flask.request.form
    back, name = _local(form.get("next", "")), form.get("login", "")[: accounts.LONGEST_LOGIN]
    try:
        person = _checked(name, form.get("password", ""))
    except Refusal as refusal:
        page = flask.render_template("login.html", back=back, problem=refusal.message, login=name)
        return page, refusal.status, _headers(refusal)
    sign_in(person)
    return flask.redirect(here(back), 303)


@blueprint.post("/logout")
def logout() -> ResponseReturnValue:
    """Sign out, in all browsers."""
    with transaction(installation().engine) as session:
        person = current_person(session)
        if person is not None:
            end_sessions(session, person)
            note(session, name_of(person), "signed out")
    sign_out()
    return flask.redirect(flask.url_for("account.login", signed_out="yes"), 303)


@blueprint.get("/setup/<token>")
def setup(token: str) -> str:
    """Show the form of a link: for a login and a password, or only for a new password."""
    with reading(installation().engine) as session:
        return _setup_page(session, token)


@blueprint.post("/setup/<token>")
@limited(sign_ins, by_address=True)
def use_link_(token: str) -> ResponseReturnValue:
    """Make the login, or set the password."""
    form = flask.request.form
    try:
        with transaction(installation().engine) as session:
            read_link(session, token)
            _check_same(form.get("password", ""), form.get("again", ""))
            person = use_link(session, token, form.get("login", ""), form.get("password", ""))
            if person.blocked_at is None:
                note(session, name_of(person), "signed in")
    except Refusal as refusal:
        if refusal.status != 422:
            raise
        with reading(installation().engine) as session:
            return _setup_page(session, token, problem=refusal.message), 422
    if person.blocked_at is not None:
        raise Refusal(403, gettext(BLOCKED))
    sign_in(person)
    return flask.redirect(here("/"), 303)


@blueprint.get("/account")
def own_account() -> str:
    """Show a person's own account."""
    with reading(installation().engine) as session:
        return _account_page(required_person(session, "annotator"))


@blueprint.post("/account/password")
@limited(sign_ins, by_address=True)
def change_password() -> ResponseReturnValue:
    """Change one's own password. All other sessions end."""
    form = flask.request.form
    with reading(installation().engine) as session:
        person = required_person(session, "annotator")
    try:
        _check_same(form.get("password", ""), form.get("again", ""))
        accounts.check_password(form.get("password", ""), person.login or "")
        _checked(person.login or "", form.get("current", ""), signs_in=False)
        with transaction(installation().engine) as session:
            person = required_person(session, "annotator")
            accounts.set_password(session, person, form["password"], actor=name_of(person))
    except Refusal as refusal:
        if refusal.status not in (422, 429):
            raise
        is_wrong = refusal.message == gettext(WRONG)
        problem = gettext("This isn't your password.") if is_wrong else refusal.message
        return _account_page(person, problem=problem), refusal.status, _headers(refusal)
    sign_in(person)
    return flask.redirect(flask.url_for("account.own_account", changed="yes"), 303)


class TooMany(Refusal):
    """Too many wrong passwords: when to come again."""

    def __init__(self, wait_s: float) -> None:
        self.wait_s = max(1, math.ceil(wait_s))
        minutes = math.ceil(self.wait_s / 60)
        message = (
            ngettext(
                "There were too many wrong passwords. Try again in %(num)s second.",
                "There were too many wrong passwords. Try again in %(num)s seconds.",
                self.wait_s,
            )
            if self.wait_s < 100
            else ngettext(
                "There were too many wrong passwords. Try again in %(num)s minute.",
                "There were too many wrong passwords. Try again in %(num)s minutes.",
                minutes,
            )
        )
        super().__init__(429, message)


def _checked(login: str, password: str, *, signs_in: bool = True) -> Person:
    """Return the person with a login and password; count each look at a password first."""
    address, engine = flask.request.remote_addr or "", installation().engine
    with transaction(engine) as session:
        wait_s = failed_sign_ins.begin(session, login, address, now=now())
        if wait_s > 0:  # and nothing is kept: rows of made-up logins would fill the table
            raise TooMany(wait_s)
    with reading(engine) as session:
        known = accounts.find(session, login)
        person = accounts.matching(session, login, password)
    with transaction(engine) as session:
        if person is None or person.blocked_at is not None:
            # What was typed as a login may be a password: only those that there are are noted.
            who = "somebody" if known is None else name_of(known)
            reason = "wrong password" if person is None else "blocked"
            note(session, who, "sign-in refused", reason=reason)
        else:
            failed_sign_ins.succeeded(session, login, address)
            if signs_in:
                note(session, name_of(person), "signed in")
    if person is None:
        raise Refusal(422, gettext(WRONG))
    if person.blocked_at is not None:
        raise Refusal(403, gettext(BLOCKED))
    return person


def _check_same(password: str, again: str) -> None:
    if password != again:
        raise Refusal(422, gettext(DIFFER))


def _headers(refusal: Refusal) -> dict[str, str]:
    return {"Retry-After": str(refusal.wait_s)} if isinstance(refusal, TooMany) else {}


def _setup_page(session: Session, token: str, problem: str | None = None) -> str:
    link, person = read_link(session, token)
    return flask.render_template(
        "setup.html",
        token=token,
        link=link,
        whose=person,
        problem=problem,
        login=flask.request.form.get("login", "")[: accounts.LONGEST_LOGIN],
        shortest=accounts.SHORTEST_PASSWORD,
    )


def _account_page(person: Person, problem: str | None = None) -> str:
    return flask.render_template(
        "account.html",
        person=person,
        problem=problem,
        is_changed="changed" in flask.request.args,
        shortest=accounts.SHORTEST_PASSWORD,
        idle_hours=installation().config.idle_hours,
    )


def _local(address: str) -> str:
    """Return a place of this app to go back to; ignore a link's address of another site."""
    is_local = address.startswith("/") and address[1:2] not in ("/", "\\") and address.isprintable()
    return address if is_local else "/"
