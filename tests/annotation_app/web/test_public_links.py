"""Links within the app and to it: behind a proxy with a path of its own, and for people to come."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from flask import Flask

from annotation_app.core.config import Config
from annotation_app.serving.factory import create_app
from corpus_tools.cli.console import run
from tests.annotation_app.browser import Browser, engine_of
from tests.annotation_app.signing_in import signed_in

PREFIX = "/lab/annotate"
LINK = re.compile(r"""(?:href|src|action)="(/[^"]*)\"""")
PAGES = ("/", "/login", "/s/tests", "/s/tests/describe", "/practice/describe?study=tests", "/none")


def behind(config: Config, app: Flask, **settings: object) -> Flask:
    """The app behind a proxy that serves it under a path."""
    return create_app(replace(config, proxies=1, **settings), engine_of(app))  # type: ignore[arg-type]


def test_all_links_of_pages_begin_with_the_proxys_path(app: Flask, config: Config) -> None:
    person = Browser(behind(config, app))
    person.practise("describe")
    person.client.environ_base["HTTP_X_FORWARDED_PREFIX"] = PREFIX
    for path in PAGES:
        links = LINK.findall(person.client.get(path).text)
        assert links
        assert [link for link in links if not link.startswith(f"{PREFIX}/")] == []
    assert f'<meta name="root" content="{PREFIX}">' in person.client.get("/").text


def test_where_pages_lead_to_begins_with_the_proxys_path(app: Flask, config: Config) -> None:
    stranger = behind(config, app).test_client()
    stranger.environ_base["HTTP_X_FORWARDED_PREFIX"] = PREFIX
    assert stranger.get("/s/tests").headers["Location"] == f"{PREFIX}/s/tests/welcome"
    admin = signed_in(behind(config, app), "ada", "admin")
    admin.client.environ_base["HTTP_X_FORWARDED_PREFIX"] = PREFIX
    for path in ("/dashboard", "/admin/logins", "/dashboard/tests"):
        links = LINK.findall(admin.client.get(path).text)
        assert [link for link in links if not link.startswith(f"{PREFIX}/")] == []


def test_a_path_is_believed_of_proxies_only(app: Flask) -> None:
    client = app.test_client()
    page = client.get("/", headers={"X-Forwarded-Prefix": PREFIX}).text
    assert PREFIX not in page


@pytest.mark.parametrize("prefix", ["//evil.example", "/a b", '/"onload="x', "/a//b", "/a/"])
def test_a_path_that_is_none_is_ignored(app: Flask, config: Config, prefix: str) -> None:
    client = behind(config, app).test_client()
    reply = client.get("/", headers={"X-Forwarded-Prefix": prefix})
    assert reply.status_code == 200
    root = "/a" if prefix == "/a/" else ""
    assert f'<meta name="root" content="{root}">' in reply.text
    if not root:
        assert prefix not in reply.text


def test_invitations_begin_with_the_address_that_the_app_was_started_with(
    app: Flask, config: Config
) -> None:
    url = f"https://lab.example.org{PREFIX}"
    admin = signed_in(behind(config, app, url=url), "ada", "admin")
    admin.client.environ_base["HTTP_X_FORWARDED_PREFIX"] = PREFIX
    form = {"csrf_token": admin.csrf, "role": "annotator"}
    headers = {"X-Forwarded-Host": "evil.example"}
    page = admin.client.post("/admin/logins/invite", data=form, headers=headers).text
    assert re.search(rf"{url}/setup/[\w-]+", page)
    assert "evil.example" not in page


@pytest.mark.parametrize("url", ["lab.example.org", "ftp://x", "https://me@x.org", "https://x?a"])
def test_what_is_no_address_is_refused(tmp_path: Path, url: str) -> None:
    assert run(["annotate", "serve", "--instance", str(tmp_path / "i"), "--url", url]) == 2
    assert not (tmp_path / "i").exists()
