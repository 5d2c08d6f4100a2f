"""Pages on which admins add, invite, block, reset and remove people with a login."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import flask
from flask import Blueprint
from flask.typing import ResponseReturnValue
from sqlalchemy.orm import Session

from annotation_app.core.problems import Refusal
from annotation_app.people import account_links, accounts
from annotation_app.people.browser_sessions import required_person
from annotation_app.store.audit import name_of
from annotation_app.store.database import reading, transaction
from annotation_app.store.installation import installation
from annotation_app.store.models import Person, Role
from annotation_app.web.needs_login import refused

blueprint = Blueprint("login_admin", __name__, url_prefix="/admin")
blueprint.register_error_handler(Refusal, refused)

ABOUT_ROLES: dict[Role, str] = {
    "annotator": "does tasks that ask for a login, and sees how studies are going",
    "adjudicator": "also decides disputes, sees everybody's work, and exports",
    "admin": "also manages logins, blocks people, and reads the audit trail",
}


@blueprint.get("/logins")
def logins() -> str:
    """Everybody with a login, and forms to add others."""
    with reading(installation().engine) as session:
        return _list_page(session, required_person(session, "admin"))


@blueprint.post("/logins/invite")
def invite() -> ResponseReturnValue:
    """Make a link by which somebody chooses a login."""
    with transaction(installation().engine) as session:
        admin = required_person(session, "admin")
        role = _role()
        token = account_links.invite(session, role, actor=name_of(admin))
        whom = f"Whoever opens it first chooses a login with the role {role}."
        return _link_page(admin, f"A link for a new {role}", whom, token)


@blueprint.post("/logins/add")
def add() -> ResponseReturnValue:
    """Add a login, whose password is set by a link."""

    def change(session: Session, admin: Person) -> ResponseReturnValue:
        login = flask.request.form.get("login", "")
        person = accounts.add_login(session, login, _role(), actor=name_of(admin))
        return _password_link_page(session, admin, person)

    return _changed(change)


@blueprint.post("/invitations/withdraw")
def withdraw() -> ResponseReturnValue:
    """Make an invitation void."""

    def change(session: Session, admin: Person) -> ResponseReturnValue:
        digest = flask.request.form.get("invitation", "")
        account_links.withdraw(session, digest, actor=name_of(admin))
        return _to_list()

    return _changed(change)


@blueprint.get("/logins/<person_id>")
def one(person_id: str) -> str:
    """Somebody with a login, and what can be changed."""
    with reading(installation().engine) as session:
        admin = required_person(session, "admin")
        return _one_page(session, admin, _find(session, person_id))


@blueprint.post("/logins/<person_id>/role")
def change_role(person_id: str) -> ResponseReturnValue:
    """Give somebody another role."""
    return _changed_one(
        person_id,
        lambda session, admin, person: accounts.change_role(
            session, person, _role(), actor=name_of(admin)
        ),
    )


@blueprint.get("/logins/<person_id>/block")
def confirm_block(person_id: str) -> str:
    """Whether somebody is really to sign in no more."""
    with reading(installation().engine) as session:
        admin = required_person(session, "admin")
        found = _find(session, person_id)
        return flask.render_template(
            "dashboard/block.html",
            person=admin,
            name=found.login,
            about="Their sessions end at once, and they can't sign in. You can unblock them.",
            action=flask.url_for("login_admin.block", person_id=found.id),
            back=flask.url_for("login_admin.one", person_id=found.id),
        )


@blueprint.post("/logins/<person_id>/block")
def block(person_id: str) -> ResponseReturnValue:
    """Let somebody sign in no more."""
    return _changed_one(
        person_id,
        lambda session, admin, person: accounts.block(session, person, actor=name_of(admin)),
    )


@blueprint.post("/logins/<person_id>/unblock")
def unblock(person_id: str) -> ResponseReturnValue:
    """Let somebody sign in again, at once."""
    return _changed_one(
        person_id,
        lambda session, admin, person: accounts.unblock(session, person, actor=name_of(admin)),
    )


@blueprint.post("/logins/<person_id>/reset")
def reset(person_id: str) -> ResponseReturnValue:
    """Take somebody's password away, and make a link to set a new one."""

    def change(session: Session, admin: Person, person: Person) -> ResponseReturnValue:
        accounts.reset(session, person, actor=name_of(admin))
        return _password_link_page(session, admin, person)

    return _changed_one(person_id, change)


@blueprint.get("/logins/<person_id>/remove")
def confirm(person_id: str) -> str:
    """Whether somebody is really to be removed."""
    with reading(installation().engine) as session:
        admin = required_person(session, "admin")
        found = _find(session, person_id)
        return flask.render_template("dashboard/login_remove.html", person=admin, found=found)


@blueprint.post("/logins/<person_id>/remove")
def remove(person_id: str) -> ResponseReturnValue:
    """Take somebody's login away; their answers stay."""

    def change(session: Session, admin: Person, person: Person) -> ResponseReturnValue:
        accounts.remove(session, person, actor=name_of(admin))
        return _to_list()

    return _changed_one(person_id, change)


def _changed(change: Callable[[Session, Person], ResponseReturnValue]) -> ResponseReturnValue:
    """Make a change, or show the list of logins with the reason why not."""
    engine = installation().engine
    try:
        with transaction(engine) as session:
            return change(session, required_person(session, "admin"))
    except Refusal as refusal:
        if refusal.status in (401, 403):
            raise
        with reading(engine) as session:
            admin = required_person(session, "admin")
            return _list_page(session, admin, problem=refusal.message), refusal.status


def _changed_one(
    person_id: str, change: Callable[[Session, Person, Person], Any]
) -> ResponseReturnValue:
    """Change somebody else, or show their page with the reason why not."""
    engine = installation().engine
    try:
        with transaction(engine) as session:
            admin = required_person(session, "admin")
            person = _find(session, person_id)
            if person.id == admin.id:
                raise Refusal(422, "This is your own login. Another admin can change it.")
            shown: ResponseReturnValue | None = change(session, admin, person)
            if shown is not None:
                return shown
    except Refusal as refusal:
        if refusal.status != 422:
            raise
        with reading(engine) as session:
            admin = required_person(session, "admin")
            person = _find(session, person_id)
            return _one_page(session, admin, person, problem=refusal.message), refusal.status
    return flask.redirect(flask.url_for("login_admin.one", person_id=person_id), 303)


def _find(session: Session, person_id: str) -> Person:
    person = session.get(Person, person_id)
    if person is None or person.login is None:
        raise Refusal(404, "There is no such login.")
    return person


def _role() -> Role:
    role = flask.request.form.get("role", "")
    for known in accounts.ROLES:
        if role == known:
            return known
    raise Refusal(422, "Choose a role.")


def _to_list() -> ResponseReturnValue:
    return flask.redirect(flask.url_for("login_admin.logins"), 303)


def _list_page(session: Session, admin: Person, problem: str | None = None) -> str:
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


def _one_page(session: Session, admin: Person, person: Person, problem: str | None = None) -> str:
    account = next(a for a in accounts.accounts(session) if a.person_id == person.id)
    return flask.render_template(
        "dashboard/login.html", person=admin, account=account, roles=ABOUT_ROLES, problem=problem
    )


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
        link=flask.url_for("account.setup", token=token, _external=True),
        days=account_links.INVITATION_DAYS,
    )
