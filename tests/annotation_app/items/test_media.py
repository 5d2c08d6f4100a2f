"""Videos come in the parts that players ask for, however large they are."""

from __future__ import annotations

from pathlib import Path

import pytest
from flask import Flask
from sqlalchemy import update

from annotation_app.core.config import Config
from annotation_app.store.models import Media
from corpus_tools.video.probe import file_digest
from tests.annotation_app.browser import Browser, execute
from tests.annotation_app.real_server import running

SIZE = 5 * 2**30


@pytest.mark.slow
def test_parts_of_a_large_video(app: Flask, config: Config, tmp_path: Path) -> None:
    person = Browser(app)
    name = person.take("describe")["payload"]["video"]
    video = tmp_path / "large.mp4"
    with video.open("wb") as file:  # with a hole, which takes no room
        for at, content in ((0, b"first"), (2**32, b"middle"), (SIZE - 4, b"last")):
            file.seek(at)
            file.write(content)
    execute(
        app,
        update(Media).where(Media.id == name).values(path=str(video), sha256=file_digest(video)),
    )
    parts = {
        "bytes=0-4": ("first", f"bytes 0-4/{SIZE}"),
        f"bytes={2**32}-{2**32 + 5}": ("middle", f"bytes {2**32}-{2**32 + 5}/{SIZE}"),
        f"bytes={SIZE - 4}-": ("last", f"bytes {SIZE - 4}-{SIZE - 1}/{SIZE}"),
        "bytes=-4": ("last", f"bytes {SIZE - 4}-{SIZE - 1}/{SIZE}"),
    }
    with running(config, tmp_path) as server:
        client = server.client(person)
        for asked, (content, told) in parts.items():
            client.headers["Range"] = asked
            status, found, headers = client.send("GET", f"/media/{name}", None)
            assert (status, found, headers["content-range"]) == (206, content, told)
            assert headers["content-type"] == "video/mp4"
            assert headers["accept-ranges"] == "bytes"
        client.headers["Range"] = f"bytes={SIZE}-"
        assert client.send("GET", f"/media/{name}", None)[0] == 416
