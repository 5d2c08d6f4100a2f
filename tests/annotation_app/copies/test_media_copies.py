"""Copies of videos and pictures for a web server, an object store or a CDN."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from click.testing import CliRunner
from flask import Flask

from annotation_app.cli.annotate_commands import annotate
from annotation_app.core.config import Config
from annotation_app.serving.factory import create_app
from tests.annotation_app.browser import Browser, engine_of
from tests.annotation_app.crowds.stand_ins import Reply, serving
from tests.annotation_app.rendered import VIDEOS, WORDS

FILES = 3 * len(VIDEOS)
"""A video, its poster and its outlines."""


def copied(config: Config, target: str) -> str:
    arguments = ["copy-media", target, "--instance", str(config.instance)]
    result = CliRunner().invoke(annotate, arguments)
    assert result.exit_code == 0, result.output
    return result.output


def test_browsers_are_sent_to_copies(app: Flask, config: Config, tmp_path: Path) -> None:
    person = Browser(app)
    name = person.take("describe")["payload"]["video"]
    own = person.client.get(f"/media/{name}", buffered=True).data
    assert f"copied {FILES} files" in copied(config, str(tmp_path / "copies"))
    assert "copied 0 files" in copied(config, str(tmp_path / "copies"))
    copies = {path.name: path.read_bytes() for path in (tmp_path / "copies").iterdir()}
    assert not any(word in file for file in copies for word in WORDS)

    config = replace(config, media_url="https://cdn.example.org/g3/")
    elsewhere = create_app(config, engine_of(app))
    assert elsewhere.test_client().get(f"/media/{name}").status_code == 401
    sent = Browser(elsewhere).client.get(f"/media/{name}")
    assert sent.status_code == 302
    address = urlsplit(sent.headers["Location"])
    assert address.hostname == "cdn.example.org"
    assert copies[Path(address.path).name] == own
    policy = sent.headers["Content-Security-Policy"]
    assert "media-src 'self' https://cdn.example.org;" in policy
    assert "script-src 'self';" in policy


class Store:
    """An object store with the two requests that are used."""

    def __init__(self) -> None:
        self.kept: dict[str, tuple[str, bytes]] = {}

    def __call__(self, method: str, path: str, headers: dict[str, str], body: bytes) -> Reply:
        assert "AWS4-HMAC-SHA256" in headers["HTTP_AUTHORIZATION"]
        if method == "PUT":
            self.kept[path] = (headers["CONTENT_TYPE"], body)
        return 200 if path in self.kept else 404, None


def test_copies_in_an_object_store(
    app: Flask, config: Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = Store()
    for key in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        monkeypatch.setenv(key, "test")
    monkeypatch.setenv("AWS_EC2_METADATA_DISABLED", "true")
    with serving(store) as address:
        monkeypatch.setenv("AWS_ENDPOINT_URL_S3", address)
        assert f"copied {FILES} files" in copied(config, "s3://bucket/some/media")
        assert "copied 0 files" in copied(config, "s3://bucket/some/media")
    assert {path.rpartition("/")[0] for path in store.kept} == {"/bucket/some/media"}
    assert {kind for kind, _ in store.kept.values()} == {"video/mp4", "image/png"}
