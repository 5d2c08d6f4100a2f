"""Pages for admins: people with a login, the audit trail, and tokens by which programs read."""

from __future__ import annotations

import flask
from flask import Blueprint
from flask.typing import ResponseReturnValue
from sqlalchemy.orm import Session

from annotation_app.core.problems import Refusal
from annotation_app.dashboard.answer_browsing import read_before
from annotation_app.dashboard.dashboard_charts import in_utc
from annotation_app.people import account_links, accounts, api_tokens
from annotation_app.people.api_tokens import MOST_DAYS
from annotation_app.store.audit import actions, name_of, trail
from annotation_app.store.installation import now
from annotation_app.store.models import Person, Role
from annotation_app.web.public_links import public
from annotation_app.web.who_asks import changed_by, refused, refused_on, seen_by

blueprint = Blueprint("login_admin", __name__, url_prefix="/admin")
blueprint.register_error_handler(Refusal, refused)

ABOUT_ROLES: dict[Role, str] = {
    "annotator": "does tasks that ask for a login, and sees how studies are going",
    "adjudicator": "also decides disputes, sees everybody's work, and exports",
    "admin": "also manages logins, blocks people, and reads the audit trail",
}

ENTRIES = 50
"""Number of entries of the audit trail on a page."""


def _find(session: Session, person_id: str) -> Person:
    person = session.get(Person, person_id)
    if person is None or person.login is None:
        raise Refusal(404, "There is no such login.")
    return person


def _list_page(session: Session, admin: Person, problem: str = "") -> str:
    return flask.render_template(
        "dashboard/logins.html",
        person=admin,
        accounts=accounts.accounts(session),
        invitations=account_links.open_invitations(session),
        roles=ABOUT_ROLES,
        days=account_links.INVITATION_DAYS,
        problem=problem,
        form=flask.request.form,
    )


def _one_page(session: Session, admin: Person, person_id: str, problem: str = "") -> str:
    person = _find(session, person_id)
    account = next(a for a in accounts.accounts(session) if a.person_id == person.id)
    return flask.render_template(
        "dashboard/login.html", person=admin, account=account, roles=ABOUT_ROLES, problem=problem
    )


@blueprint.get("/logins")
def logins() -> str:
    """Show everybody with a login, and forms to add others."""
    with seen_by("admin") as (session, admin):
        return _list_page(session, admin)


@blueprint.post("/logins/invite")
def invite() -> ResponseReturnValue:
    """Make a link by which somebody chooses a login."""
    with changed_by("admin") as (session, admin):
        role = _role()
        token = account_links.invite(session, role, actor=name_of(admin))
        whom = f"Whoever opens it first chooses a login with the role {role}."
        return _link_page(admin, f"A link for a new {role}", whom, token)


@blueprint.post("/logins/add")
@refused_on(_list_page)
def add() -> ResponseReturnValue:
    """Add a login, whose password is set by a link."""
    with changed_by("admin") as (session, admin):
        login = flask.request.form.get("login", "")
        person = accounts.add_login(session, login, _role(), actor=name_of(admin))
        return _password_link_page(session, admin, person)


@blueprint.post("/invitations/withdraw")
@refused_on(_list_page)
def withdraw() -> ResponseReturnValue:
    """Make an invitation void."""
    with changed_by("admin") as (session, admin):
        digest = flask.request.form.get("invitation", "")
        account_links.withdraw(session, digest, actor=name_of(admin))
    return _to_list()


@blueprint.get("/logins/<person_id>")
def one(person_id: str) -> str:
    """Show somebody with a login, and the possible changes."""
    with seen_by("admin") as (session, admin):
        return _one_page(session, admin, person_id)


@blueprint.post("/logins/<person_id>/role")
@refused_on(_one_page)
def change_role(person_id: str) -> ResponseReturnValue:
    """Give somebody another role."""
    with changed_by("admin") as (session, admin):
        person = _another(session, admin, person_id)
        accounts.change_role(session, person, _role(), actor=name_of(admin))
    return _to_one(person_id)


@blueprint.get("/logins/<person_id>/block")
def confirm_block(person_id: str) -> str:
    """Ask for confirmation that somebody can't sign in any more."""
    with seen_by("admin") as (session, admin):
        found = _find(session, person_id)
        return flask.render_template(
            "dashboard/block.html",
            person=admin,
            name=found.login,
            about="Their sessions end at once, and they can't sign in. You can unblock them.",
            back=flask.url_for("login_admin.one", person_id=found.id),
        )


@blueprint.post("/logins/<person_id>/block")
@refused_on(_one_page)
def block(person_id: str) -> ResponseReturnValue:
    """Let somebody sign in no more."""
    with changed_by("admin") as (session, admin):
        person = _another(session, admin, person_id)
        accounts.block(session, person, actor=name_of(admin))
    return _to_one(person_id)


@blueprint.post("/logins/<person_id>/unblock")
@refused_on(_one_page)
def unblock(person_id: str) -> ResponseReturnValue:
    """Let somebody sign in again, at once."""
    with changed_by("admin") as (session, admin):
        person = _another(session, admin, person_id)
        accounts.unblock(session, person, actor=name_of(admin))
    return _to_one(person_id)


@blueprint.post("/logins/<person_id>/reset")
@refused_on(_one_page)
def reset(person_id: str) -> ResponseReturnValue:
    """Take somebody's password away, and make a link to set a new one."""
    with changed_by("admin") as (session, admin):
        person = _another(session, admin, person_id)
        accounts.reset(session, person, actor=name_of(admin))
        return _password_link_page(session, admin, person)


@blueprint.get("/logins/<person_id>/remove")
def confirm(person_id: str) -> str:
    """Ask for confirmation that somebody is removed."""
    with seen_by("admin") as (session, admin):
        return flask.render_template(
            "dashboard/login_remove.html",
            person=admin,
            found=_find(session, person_id),
            back=flask.url_for("login_admin.one", person_id=person_id),
        )


@blueprint.post("/logins/<person_id>/remove")
@refused_on(_one_page)
def remove(person_id: str) -> ResponseReturnValue:
    """Take somebody's login away; their answers stay."""
    with changed_by("admin") as (session, admin):
        accounts.remove(session, _another(session, admin, person_id), actor=name_of(admin))
    return _to_list()


@blueprint.get("/audit")
def audit() -> str:
    """Show the audit trail, newest first."""
    asked = flask.request.args
    person, action = asked.get("person", "").strip(), asked.get("action", "")
    with seen_by("admin") as (session, admin):
        before = read_before(asked)
        found = trail(session, person=person, action=action, before=before, most=ENTRIES + 1)
        return flask.render_template(
            "dashboard/audit.html",
            person=admin,
            entries=found[:ENTRIES],
            older=found[ENTRIES - 1].id if len(found) > ENTRIES else None,
            actions=actions(session),
            asked_person=person,
            asked_action=action,
        )


@blueprint.app_template_filter("moment")
def moment(at: float | None) -> str:
    """Format a time for people, in UTC, as the server can't know where they are."""
    return "never" if at is None else in_utc(at, "%Y-%m-%d %H:%M UTC")


def _another(session: Session, admin: Person, person_id: str) -> Person:
    """Return somebody with a login who isn't the admin."""
    person = _find(session, person_id)
    if person.id == admin.id:
        raise Refusal(422, "This is your own login. Another admin can change it.")
    return person


def _role() -> Role:
    role = flask.request.form.get("role", "")
    for known in accounts.ROLES:
        if role == known:
            return known
    raise Refusal(422, "Choose a role.")


def _to_list() -> ResponseReturnValue:
    return flask.redirect(flask.url_for("login_admin.logins"), 303)


def _to_one(person_id: str) -> ResponseReturnValue:
    return flask.redirect(flask.url_for("login_admin.one", person_id=person_id), 303)


def _password_link_page(session: Session, admin: Person, person: Person) -> str:
    token = account_links.password_link(session, person, actor=name_of(admin))
    whom = f"Whoever opens it first sets the password of {person.login}."
    return _link_page(admin, f"A link for {person.login}", whom, token)


def _link_page(admin: Person, title: str, whom: str, token: str) -> str:
    return flask.render_template(
        "dashboard/login_link.html",
        person=admin,
        heading=title,
        whom=whom,
        shown=public("account.setup", token=token),
        days=account_links.INVITATION_DAYS,
    )


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
            back=flask.url_for("login_admin.tokens"),
        )


@blueprint.post("/tokens/revoke")
def revoke() -> ResponseReturnValue:
    """Let a token read nothing any more."""
    with changed_by("admin") as (session, admin):
        api_tokens.revoke_token(session, flask.request.form.get("name", ""), actor=name_of(admin))
    return flask.redirect(flask.url_for("login_admin.tokens"), 303)
