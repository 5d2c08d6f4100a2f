"""A server that is asked to end finishes what was begun, and says where it is only when it is."""

from __future__ import annotations

import json
import signal
import socket
import sqlite3
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager
from pathlib import Path

import pytest
from flask import Flask
from sqlalchemy import select

from annotation_app.core.config import Config
from annotation_app.store.database import reading
from annotation_app.store.models import Event, Secret
from annotation_app.trying.start_scene import scenarios
from tests.annotation_app.browser import Browser, described, engine_of, rows_in
from tests.annotation_app.real_server import PATIENCE_S, Client, new_uuid, running

pytestmark = pytest.mark.slow
SIGNALS = pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
CLIENTS = 12


@contextmanager
def nobody_can_write(config: Config) -> Iterator[sqlite3.Connection]:
    """Keep all who write waiting."""
    with closing(sqlite3.connect(config.database, isolation_level=None)) as connection:
        connection.execute("BEGIN IMMEDIATE")
        yield connection


def is_running(pid: str) -> bool:
    try:
        return bool(
            Path(f"/proc/{pid}/cmdline").read_bytes()
        )  # empty where nobody has waited for it
    except OSError:
        return False


def head(client: Client, path: str, content: bytes) -> bytes:
    headers = {**client.headers, "Host": "localhost", "Content-Length": str(len(content))}
    lines = "".join(f"{name}: {value}\r\n" for name, value in headers.items())
    return f"POST {path} HTTP/1.1\r\n{lines}\r\n".encode()


@SIGNALS
def test_requests_that_were_begun_are_finished(
    app: Flask, config: Config, number: int, tmp_path: Path
) -> None:
    """Eight are being answered, others wait for their turn or haven't come completely."""
    people = [Browser(app) for _ in range(4)]
    item = {person.person.id: person.take("describe")["item"] for person in people}
    with running(config, tmp_path) as server, ThreadPoolExecutor(CLIENTS) as pool:
        clients = [(server.client(person), person) for person in people * 3]
        idle = server.client(people[0])
        assert idle.send("GET", "/api/session", None)[0] == 200
        events = [new_uuid() for _ in clients]
        slow, slow_event = server.client(people[0]), new_uuid()
        sent = json.dumps({"uuid": slow_event, "body": described("Slowly")}).encode()
        path = f"/api/items/{item[people[0].person.id]}/answer"
        with (
            socket.create_connection(("127.0.0.1", server.port), PATIENCE_S) as receiving,
            nobody_can_write(config) as lock,
        ):
            receiving.sendall(head(slow, path, sent) + sent[:-10])
            replies = [
                pool.submit(client.answer, item[person.person.id], described(), event)
                for (client, person), event in zip(clients, events, strict=True)
            ]
            time.sleep(1)
            server.process.send_signal(number)
            time.sleep(0.5)
            assert not any(reply.done() for reply in replies)
            lock.execute("ROLLBACK")
            receiving.sendall(sent[-10:])
            with receiving.makefile("rb") as file:
                assert file.readline() == b"HTTP/1.1 200 OK\r\n"
                assert file.read().endswith(b"}")  # and it is closed
        assert [reply.result()[0] for reply in replies] == [200] * CLIENTS
        assert server.process.wait(PATIENCE_S) == 0
        with pytest.raises(OSError, match="refused"):
            socket.create_connection(("127.0.0.1", server.port), 1)
    assert set(rows_in(app, select(Event.uuid))) == {*events, slow_event}
    assert server.logged() == []


def test_who_never_finishes_is_cut_off(app: Flask, config: Config, tmp_path: Path) -> None:
    with (
        running(config, tmp_path, in_background=True) as server,
        socket.create_connection(("127.0.0.1", server.port)) as one,
    ):
        one.sendall(b"POST /api/items/x/answer HTTP/1.1\r\nHost: x\r\nContent-Length: 100\r\n\r\n{")
        time.sleep(0.3)
        assert server.end(signal.SIGINT) == 0
        assert one.recv(1) == b""
    assert server.logged() == [
        "WARNING annotation_app.serving.server: requests that took longer than 7 s were cut off"
    ]


def test_a_second_signal_ends_it_at_once(config: Config, app: Flask, tmp_path: Path) -> None:
    with (
        running(config, tmp_path) as server,
        socket.create_connection(("127.0.0.1", server.port)) as one,
    ):
        one.sendall(b"POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 100\r\n\r\n{")
        time.sleep(0.3)
        server.process.send_signal(signal.SIGINT)
        time.sleep(0.5)
        assert server.process.poll() is None
        assert server.end(signal.SIGINT) == -signal.SIGINT


def test_it_ends_while_a_command_is_tried(app: Flask, config: Config, tmp_path: Path) -> None:
    """The process that follows it takes long, and is ended too."""
    with running(config, tmp_path, "--open-trying", in_background=True) as server:
        client = server.client(Browser(app))
        asked = {"scenario": min(scenarios()), "text": "Pick up the tires."}
        status, reply, _ = client.send("POST", "/api/try", asked)
        assert status == 200, reply
        time.sleep(0.5)
        family = subprocess.run(
            ["ps", "--ppid", str(server.process.pid), "-o", "pid="],
            capture_output=True,
            text=True,
            check=False,
        ).stdout.split()
        assert family
        assert server.end(signal.SIGTERM) == 0
        time.sleep(0.5)
        assert [pid for pid in family if is_running(pid)] == []


def test_nothing_but_the_error_is_told_where_the_port_is_taken(
    app: Flask, config: Config, tmp_path: Path
) -> None:
    with running(config, tmp_path) as server:
        with reading(engine_of(app)) as session:
            links = session.execute(select(Secret.name, Secret.value)).all()
        serve = [sys.executable, "-m", "corpus_tools", "annotate", "serve"]
        serve += ["--instance", str(config.instance)]
        for host in ("127.0.0.1", "localhost"):
            second = subprocess.run(
                [*serve, "--host", host, "--port", str(server.port)],
                capture_output=True,
                text=True,
                check=False,
            )
            assert (second.returncode, second.stdout) == (2, "")
            (line,) = second.stderr.splitlines()
            assert line.startswith("ct: error: ")
            assert f"{host}:{server.port}" in line
            assert "Address already in use" in line
        with reading(engine_of(app)) as session:
            assert session.execute(select(Secret.name, Secret.value)).all() == links


def test_addresses_are_told_when_they_can_be_opened(
    app: Flask, config: Config, tmp_path: Path
) -> None:
    with running(config, tmp_path) as server:
        assert f"study tests: http://localhost:{server.port}/s/tests\n" in server.told
        with socket.create_connection(("127.0.0.1", server.port), 1):
            pass
        assert server.end() == 0
    assert server.logged() == []
