"""``ct annotate tokens``: make, list and revoke."""

from __future__ import annotations

import json
from typing import Any

import pytest
from click.testing import CliRunner, Result
from flask import Flask

from annotation_app.cli.annotate_commands import annotate
from annotation_app.core.config import Config
from g3.errors import FormatError


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
