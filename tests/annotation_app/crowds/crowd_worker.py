"""A platform's worker with a browser, and a researcher with a shell."""

from __future__ import annotations

import re
from decimal import Decimal
from typing import Any
from urllib.parse import urlsplit

from click.testing import CliRunner, Result
from flask import Flask

from annotation_app.cli.crowd_commands import crowd
from annotation_app.core.config import Config
from annotation_app.people.participants import keep_consent
from annotation_app.store.database import transaction
from annotation_app.store.models import Participation, Person
from annotation_app.work.handing_out import find_study
from tests.annotation_app.browser import Browser, described, engine_of
from tests.annotation_app.crowds.prolific_stand_in import Prolific

OPTIONS = ("--task", "describe", "--items", "2", "--people", "4")
"""Four people are to describe two videos each."""
BONUS = ("--bonus", "sub1", "0.50", "For care")
PAID = [("sub1", Decimal("0.50"))]
LAB = "https://lab.example.org"


class CrowdWorker(Browser):
    """Comes in by a platform's address. Consent is given, what is to be done is one's own."""

    def __init__(self, app: Flask, address: str, arguments: dict[str, str]) -> None:
        self.app = app
        self.client = app.test_client()
        self.engine = engine_of(app)
        self.open(address, arguments)
        self.csrf = self.client.get("/api/session").json["csrf"]

    def open(self, address: str, arguments: dict[str, str]) -> Any:
        path = urlsplit(address).path
        response = self.client.get(path, query_string=arguments)
        assert response.status_code == 302, response.text
        with self.client.session_transaction() as cookie, transaction(self.engine) as session:
            participation = session.get_one(Participation, cookie["participation"])
            person = session.get_one(Person, cookie["person"])
            assert participation.person_id == person.id
            keep_consent(person, find_study(session, "tests").id, {})
        return response

    def finish(self) -> str:
        """Read the last page."""
        response = self.client.get("/crowd/finish")
        assert response.status_code == 200, response.text
        return str(response.text)

    def submit(self, platform: Any) -> None:
        """Send the last page's form to where it goes."""
        page = self.finish()
        action = re.search(r'action="([^"]+)"', page)
        assert action is not None, page
        assert urlsplit(action[1]).path == "/mturk/externalSubmit"
        fields = re.findall(r'type="hidden" name="(\w+)" value="([^"]*)"', page)
        status, _ = platform.external_submit({name: [value] for name, value in fields})
        assert status == 200


def take_part(app: Flask, prolific: Prolific, name: str, done: int = 2) -> CrowdWorker:
    """Somebody comes in by Prolific and does so much; what is all, they send in."""
    (study,) = prolific.studies.values()
    arguments = prolific.begin(name)
    one = CrowdWorker(app, study["external_study_url"], arguments)
    for _ in range(done):
        one.do("describe", described())
    if done == 2:
        one.finish()
        prolific.submissions[arguments["SESSION_ID"]]["status"] = "AWAITING REVIEW"
    return one


class Lab:
    """The commands, for one installation and one platform."""

    def __init__(self, config: Config, endpoint: str, provider: str = "mturk") -> None:
        self.provider = provider
        self.rest = ["--endpoint", endpoint, "--instance", str(config.instance)]
        if "://" in str(config.database):
            self.rest += ["--database", str(config.database)]

    def publish(self, *options: str) -> Result:
        return self._run(["publish", self.provider, "tests", "--url", LAB, *options, *self.rest])

    def collect(self, *options: str) -> Result:
        return self._run(["collect", self.provider, "tests", *options, *self.rest])

    def reconcile(self, *options: str) -> Result:
        return self._run(["reconcile", self.provider, "tests", *options, *self.rest])

    def _run(self, arguments: list[str]) -> Result:
        return CliRunner().invoke(crowd, arguments)


def external_url(question: str) -> str:
    found = re.search(r"<ExternalURL>(.*)</ExternalURL>", question)
    assert found is not None
    return found[1]
