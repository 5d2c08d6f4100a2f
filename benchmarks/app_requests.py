"""Processor time of the annotation app by kind of request: ``python -m benchmarks.app_requests``.

One process calls the app as a WSGI server would, so that nothing is measured but the app and
its database's client.
"""

from __future__ import annotations

import argparse
import io
import json
import os
import sys
import tempfile
import time
import uuid
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
from flask import Flask

from annotation_app.core.config import open_instance
from annotation_app.serving.factory import create_app
from benchmarks.app import VIDEOS, add_study, cookies
from benchmarks.app_servers import new_databases
from benchmarks.app_workers import STUDY

PEOPLE = 60
LEASE = f"/api/studies/{STUDY}/tasks/{{task}}/lease"


class Person:
    """Somebody whose requests are timed."""

    def __init__(self, app: Flask, cookie: str, times: dict[str, list[float]]) -> None:
        self.app, self.cookie, self.times = app, cookie, times
        self.csrf = ""
        self.csrf = str(self.send("session", "GET", "/api/session")["csrf"])

    def send(self, kind: str, method: str, path: str, value: Any = None) -> dict[str, Any]:
        body = b"" if value is None else json.dumps(value).encode()
        environ = {
            "REQUEST_METHOD": method,
            "PATH_INFO": path,
            "SERVER_NAME": "127.0.0.1",
            "SERVER_PORT": "80",
            "SERVER_PROTOCOL": "HTTP/1.1",
            "REMOTE_ADDR": "127.0.0.1",
            "HTTP_COOKIE": f"session={self.cookie}",
            "HTTP_X_CSRFTOKEN": self.csrf,
            "CONTENT_TYPE": "application/json",
            "CONTENT_LENGTH": str(len(body)),
            "wsgi.input": io.BytesIO(body),
            "wsgi.errors": sys.stderr,
            "wsgi.url_scheme": "http",
        }
        told: dict[str, Any] = {}

        def start_response(status: str, headers: list[tuple[str, str]], *_: Any) -> None:
            told.update(status=int(status[:3]), headers=headers)

        start = time.process_time()
        content = b"".join(self.app(environ, start_response))  # type: ignore[arg-type]
        taken = time.process_time() - start
        assert told["status"] in (200, 409), content
        self.times[kind if told["status"] == 200 else f"{kind}, refused"].append(taken)
        for name, text in told["headers"]:
            if name == "Set-Cookie":
                self.cookie = text.partition(";")[0].removeprefix("session=")
        reply: dict[str, Any] = json.loads(content)
        return reply


def run(app: Flask, signed: list[str]) -> dict[str, list[float]]:
    """Let everybody work in turn until nothing is left; the seconds of each kind of request."""
    times: dict[str, list[float]] = defaultdict(list)
    people = [Person(app, cookie, times) for cookie in signed]
    for task in ("describe", "rate"):
        while True:
            held = [
                (person, reply["item"])
                for person in people
                if "item" in (reply := person.send("lease", "POST", LEASE.format(task=task), {}))
            ]
            for number, (person, item) in enumerate(held):
                body: dict[str, Any] = {"rating": 4}
                if task == "describe":
                    body = {"text": f"Go to {number}", "played_to_end": True}
                draft = {"revision": 1, "body": body}
                person.send("draft", "PUT", f"/api/items/{item}/draft", draft)
                answer = {"uuid": str(uuid.uuid4()), "body": body}
                person.send(f"answer, {task}", "POST", f"/api/items/{item}/answer", answer)
            if not held:
                break
    return times


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, prog="python -m benchmarks.app_requests")
    parser.add_argument("--database", choices=["sqlite", "postgresql"], default="sqlite")
    given = parser.parse_args()

    from tests.annotation_app.rendered import render  # noqa: PLC0415 - needs pytest

    print(f"{given.database}, load {os.getloadavg()[0]:.1f}")
    with tempfile.TemporaryDirectory() as folder, new_databases(given.database) as new:
        videos = render(Path(folder) / "videos", tuple(f"video{i}" for i in range(VIDEOS)))
        config = open_instance(Path(folder) / "instance", new())
        people = add_study(config, videos, PEOPLE, PEOPLE // 4)
        times = run(create_app(config), cookies(config, people))
    for kind, values in sorted(times.items()):
        median, mean = 1000 * np.median(values), 1000 * np.mean(values)
        print(f"  {kind:16} {len(values):4} times, median {median:5.2f} ms, mean {mean:5.2f} ms")
    every = [s for values in times.values() for s in values]
    print(f"  {'all':16} {len(every):4} times, mean {1000 * np.mean(every):5.2f} ms")


if __name__ == "__main__":
    main()
