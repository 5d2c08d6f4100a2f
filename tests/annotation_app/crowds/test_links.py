from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from urllib.parse import parse_qsl, urlsplit

import msgspec
import pytest
from click.testing import CliRunner, Result
from flask import Flask

from annotation_app.cli.crowd_commands import crowd
from annotation_app.core.config import Config
from annotation_app.crowds.crowd_registry import Provider, find_provider, providers, register
from annotation_app.store.database import transaction
from annotation_app.study_setup.rendered_study import put_study, rendered_videos
from g3.errors import FormatError
from tests.annotation_app.browser import described, engine_of
from tests.annotation_app.crowds.conftest import PAID
from tests.annotation_app.crowds.crowd_worker import LAB, CrowdWorker


def publish(config: Config, *options: str) -> Result:
    arguments = ["publish", "links", "tests", "--url", LAB, "--items", "2", *options]
    return CliRunner().invoke(crowd, [*arguments, "--instance", str(config.instance)])


def links(config: Config, *options: str) -> list[str]:
    result = publish(config, *options)
    assert result.exit_code == 0, result.output
    return result.output.split()


def visit(app: Flask, link: str) -> CrowdWorker:
    return CrowdWorker(app, link, dict(parse_qsl(urlsplit(link).query)))


def test_anybody_may_take_an_open_link(app: Flask, config: Config) -> None:
    (link,) = links(config)
    one, other = visit(app, link), visit(app, link)
    one.do("describe", described())
    one.open(link, {})  # the same browser is the same person
    assert "1 of 2" in one.finish()
    assert "0 of 2" in other.finish()
    one.do("describe", described("Wait."))
    assert "completion code" in one.finish()
    assert "Your code for questions about your data" in one.finish()


def test_an_open_study_has_one_link_for_all(app: Flask, config: Config) -> None:
    refused = publish(config, "--people", "5")
    assert isinstance(refused.exception, FormatError)
    assert "all people use the same link" in str(refused.exception)
    assert "access: invited" in refused.exception.fix


def test_an_invitation_is_for_one_person(app: Flask, config: Config, videos: Path) -> None:
    with transaction(engine_of(app)) as session:
        invited = msgspec.structs.replace(PAID, access="invited")
        put_study(session, invited, rendered_videos(videos))
    first, second = links(config, "--people", "2")
    one = visit(app, first)
    one.do("describe", described())
    assert "1 of 2" in visit(app, first).finish()
    assert "0 of 2" in visit(app, second).finish()
    path, query = urlsplit(first).path, dict(parse_qsl(urlsplit(first).query))
    token = query["invitation"]
    refused = app.test_client().get(path, query_string={"invitation": token[:-2]})
    assert refused.status_code == 404


def test_providers_are_registered() -> None:
    assert {"links", "mturk", "prolific"} <= {provider.name for provider in providers()}
    known = find_provider("mturk")
    assert isinstance(known, Provider)
    with pytest.raises(ValueError, match="already"):
        register(known)


def test_other_distributions_add_providers(tmp_path: Path) -> None:
    (tmp_path / "my_crowd.py").write_text(
        "from annotation_app.crowds.crowd_registry import Provider, register\n"
        "register(Provider('friends', 'Friends', 'Ask your friends.', '', 'my_crowd:FRIENDS'))\n"
    )
    info = tmp_path / "my_crowd-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: my-crowd\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[ct.crowds]\nfriends = my_crowd\n")
    done = subprocess.run(
        [sys.executable, "-m", "corpus_tools", "crowd", "collect", "--help"],
        check=True,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
    )
    assert ["friends", "What", "workers"] in [line.split()[:3] for line in done.stdout.splitlines()]
