"""``ct annotate tokens`` and ``webhooks``: what they make, list, send and take away."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest
from click.testing import CliRunner, Result
from flask import Flask

from annotation_app.cli.annotate_commands import annotate
from annotation_app.core.config import Config
from g3.errors import FormatError
from tests.annotation_app.browser import Browser, described
from tests.annotation_app.serving.receiver import receiving


def run(config: Config, *arguments: str) -> Result:
    place = ["--instance", str(config.instance), "--database", f"sqlite:///{config.database}"]
    return CliRunner().invoke(annotate, [*arguments, *place])


def told(config: Config, *arguments: str) -> Any:
    result = run(config, *arguments, "--json")
    assert result.exit_code == 0, (result.output, result.exception)
    return json.loads(result.stdout)


def refused(config: Config, *arguments: str) -> FormatError:
    result = run(config, *arguments)
    assert isinstance(result.exception, FormatError), result.output
    return result.exception


def test_tokens(app: Flask, config: Config) -> None:
    assert "there are no tokens" in run(config, "tokens", "list").output
    token = told(config, "tokens", "make", "report", "--days", "30")["token"]
    headers = {"Authorization": f"Bearer {token}"}
    path = "/api/dashboard/studies/tests/progress"
    assert app.test_client().get(path, headers=headers).status_code == 200
    (listed,) = told(config, "tokens", "list")["tokens"]
    assert (listed["name"], listed["made_by"]) == ("report", "command line")
    assert listed["expires_at"] - listed["made_at"] == pytest.approx(30 * 86_400, abs=1)
    assert token not in run(config, "tokens", "list").output
    assert "another one" in refused(config, "tokens", "make", "report").fix
    assert "letters" in refused(config, "tokens", "make", "a b").fix
    assert run(config, "tokens", "make", "x", "--days", "0").exit_code == 2
    assert run(config, "tokens", "revoke", "report").output == "report: revoked\n"
    assert app.test_client().get(path, headers=headers).status_code == 401
    assert "no such token" in str(refused(config, "tokens", "revoke", "report"))


def test_webhooks(app: Flask, config: Config) -> None:
    assert "there are no webhooks" in run(config, "webhooks", "list").output
    with receiving() as receiver:
        add = ("webhooks", "add", "tests", receiver.url)
        assert "--allow-private" in refused(config, *add).fix
        assert "no such study" in str(refused(config, "webhooks", "add", "other", receiver.url))
        made = told(config, *add, "--allow-private")
        assert re.fullmatch(r"whsec_[A-Za-z0-9+/]{43}=", made["secret"])
        person = Browser(app)
        for number in range(2):  # each of two items wants two answers
            person.do("describe", described(f"Command {number}."))
        other = Browser(app)
        while other.lease("describe").status_code == 200:
            other.do("describe", described("Go."))
        receiver.answer = lambda number: 500 if number == 0 else 204
        sent = told(config, "webhooks", "send")
        assert (sent["failed"], sent["sent"]) == (1, len(receiver.requests) - 1)
        (state,) = told(config, "webhooks", "list")["webhooks"]
        assert (state["waiting"], state["problem"]) == (1, "status 500")
        assert state["webhook"] == made["webhook"]
        assert made["secret"] not in run(config, "webhooks", "list").output
        assert told(config, "webhooks", "send")["sent"] == 0  # not yet
        assert told(config, "webhooks", "send", "--again")["sent"] == 1
    assert run(config, "webhooks", "remove", made["webhook"]).exit_code == 0
    assert "no such webhook" in str(refused(config, "webhooks", "remove", made["webhook"]))
