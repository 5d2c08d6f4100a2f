"""``ct annotate serve`` as a process of its own, and clients that speak HTTP to it."""

from __future__ import annotations

import http.client
import json
import re
import signal
import subprocess
import sys
import threading
import uuid
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from annotation_app.core.config import Config
from tests.annotation_app.browser import Browser, session_of

PATIENCE_S = 60.0


@dataclass(frozen=True)
class Server:
    """A server, where it is, and what it has said."""

    process: subprocess.Popen[str]
    port: int
    told: str
    log: Path
    clients: list[Client] = field(default_factory=list)

    def client(self, person: Browser) -> Client:
        """Somebody's browser."""
        self.clients.append(Client(self.port, person))
        return self.clients[-1]

    def logged(self) -> list[str]:
        """The lines of its log, which are those of its standard error."""
        return self.log.read_text().splitlines()

    def end(self, number: int = signal.SIGTERM) -> int:
        """Ask it to end; its exit status."""
        self.process.send_signal(number)
        return self.process.wait(PATIENCE_S)


def running(
    config: Config, folder: Path, *options: str, in_background: bool = False
) -> AbstractContextManager[Server]:
    """A server of an installation that people can connect to; see :func:`started`."""
    where = ("--instance", str(config.instance), "--database", str(config.database))
    call = ("annotate", "serve", "--port", "0", *where, *options)
    return started(folder / "log", *call, in_background=in_background)


@contextmanager
def started(log: Path, *call: str, in_background: bool = False, **process: Any) -> Iterator[Server]:
    """A server that people can connect to, by a call of ``ct``.

    Parameters
    ----------
    log
        The file for what it says on standard error.
    in_background
        Whether it is started as shells do it with "&": Ctrl-C is ignored.
    process
        Other options of the process.
    """
    command = [sys.executable, "-m", "corpus_tools", *call]
    usual = signal.signal(signal.SIGINT, signal.SIG_IGN) if in_background else None
    with (
        log.open("w") as errors,
        subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=errors, text=True, **process
        ) as server,
    ):
        if usual is not None:
            signal.signal(signal.SIGINT, usual)
        clients: list[Client] = []
        given_up = threading.Timer(2 * PATIENCE_S, server.kill)
        given_up.start()
        try:
            assert server.stdout is not None
            told = ""
            for line in iter(server.stdout.readline, ""):
                told += line
                if "Ctrl-C" in line:
                    break
            given_up.cancel()  # it is up: a test may take longer
            found = re.search(r"localhost:(\d+)/", told)
            assert found, (told, log.read_text())
            yield Server(server, int(found[1]), told, log, clients)
        finally:
            for client in clients:
                client.connection.close()
            given_up.cancel()
            server.kill()


class Client:
    """Somebody's browser, which keeps one connection."""

    def __init__(self, port: int, person: Browser) -> None:
        self.connection = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE_S)
        self.headers = {
            "Cookie": f"session={session_of(person)}",
            "X-CSRFToken": person.csrf,
            "Content-Type": "application/json",
        }

    def send(self, method: str, path: str, value: Any) -> tuple[int, Any, dict[str, str]]:
        """A request, and its status, content and headers; the next one connects anew if need be."""
        try:
            self.connection.request(method, path, json.dumps(value), self.headers)
            reply = self.connection.getresponse()
            content = reply.read()
        except (OSError, http.client.HTTPException):
            self.connection.close()
            raise
        headers = {name.lower(): text for name, text in reply.getheaders()}
        is_json = headers.get("content-type", "").startswith("application/json")
        return reply.status, json.loads(content) if is_json else content.decode(), headers

    def answer(self, item: str, body: Any, event: str) -> tuple[int, Any, dict[str, str]]:
        return self.send("POST", f"/api/items/{item}/answer", {"uuid": event, "body": body})


def new_uuid() -> str:
    return str(uuid.uuid4())
