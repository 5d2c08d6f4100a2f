"""People with a login, as far as forms are concerned."""

from __future__ import annotations

import re
from typing import Any

from flask import Flask
from flask.testing import FlaskClient

from annotation_app.people.accounts import add_login
from annotation_app.store.database import transaction
from annotation_app.store.models import Person, Role
from tests.annotation_app.browser import Browser, engine_of

PASSWORD = "correct horse battery"
LINK = re.compile(r"https?://[^/\s]+(/setup/[\w-]+)")


class Member(Browser):
    """A browser of somebody with a login."""

    def __init__(self, app: Flask, login: str, role: Role | None = None) -> None:
        """Add the login if a role is given."""
        self.app, self.login = app, login
        self.client: FlaskClient = app.test_client()
        if role is not None:
            with transaction(engine_of(app)) as session:
                self.person: Person = add_login(session, login, role, PASSWORD, actor="tests")

    @property
    def csrf(self) -> str:  # type: ignore[override]
        """The token of the session, which may be another one by now."""
        return str(self.client.get("/api/session").json["csrf"])

    def post(self, path: str, **form: str) -> Any:
        return self.client.post(path, data={"csrf_token": self.csrf, **form})

    def sign_in(self, password: str = PASSWORD, **form: str) -> Any:
        return self.post("/login", login=self.login, password=password, **form)

    def agree(self, study: str = "tests") -> None:
        """Agree to take part in a study."""
        assert self.post(f"/s/{study}/welcome", agree="on").status_code == 303

    @property
    def role(self) -> str | None:
        """As the app sees this browser."""
        found = self.client.get("/api/session").json
        role: str | None = found["role"]
        assert found["signed_in"] is (role is not None)
        return role


def signed_in(app: Flask, login: str, role: Role) -> Member:
    member = Member(app, login, role)
    assert member.sign_in().status_code == 303
    assert member.role == role
    return member


def link_in(page: str) -> str:
    """The path of the link that a page or a command shows."""
    found = LINK.search(page)
    assert found is not None, page
    return found[1]
