"""The server's connections: many that are silent, slow or broken."""

from __future__ import annotations

import asyncio
import json
import resource
import socket
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO, Any

import pytest
from flask import Flask

from annotation_app.core.config import Config
from annotation_app.serving.gateway import PART, Gateway
from annotation_app.serving.server import answer, bound, port_of
from tests.annotation_app.browser import Browser, described
from tests.annotation_app.real_server import new_uuid, running

LARGE = 40 * PART + 1
PATIENCE_S = 60.0
THREADS = 2
CLOSED: list[str] = []


def echo(environ: dict[str, Any], start_response: Callable[..., Any]) -> Iterable[bytes]:
    """Reply with what was sent, what a request is, or much; or fail."""
    path = environ["PATH_INFO"]
    content = environ["wsgi.input"].read()
    if path == "/fail":
        raise RuntimeError("no reply")
    if path == "/environ":
        content = json.dumps({k: v for k, v in environ.items() if isinstance(v, str)}).encode()
    length = LARGE if path == "/large" else len(content)
    start_response("200 OK", [("Content-Length", str(length))])
    return Large() if path == "/large" else [content]


class Large:
    """A large reply in small pieces, which notes that it is closed."""

    def __iter__(self) -> Iterator[bytes]:
        yield from (b"x" * 8192 for _ in range(LARGE // 8192))
        yield b"x" * (LARGE % 8192)

    def close(self) -> None:
        CLOSED.append("large")


@contextmanager
def served(head_s: float = 10.0) -> Iterator[Callable[..., socket.socket]]:
    """What connects to a server, from an address of this machine."""
    listens, opened, stops = threading.Event(), [], []

    async def serve() -> None:
        end, loop = asyncio.Event(), asyncio.get_running_loop()
        stops.append(lambda: loop.call_soon_threadsafe(end.set))
        gateway = Gateway(echo, threads=THREADS, body_bytes=1000)
        assert await answer(gateway, sockets, end, listening=listens.set, head_s=head_s)

    with bound("127.0.0.1", 0) as sockets, ThreadPoolExecutor() as pool:
        port = port_of(sockets)
        serving = pool.submit(asyncio.run, serve())
        assert listens.wait(PATIENCE_S)

        def connect(address: str = "127.0.0.1") -> socket.socket:
            there, here = ("127.0.0.1", port), (address, 0)
            opened.append(socket.create_connection(there, PATIENCE_S, source_address=here))
            return opened[-1]

        try:
            yield connect
        finally:
            for connection in opened:
                connection.close()
            stops[0]()
            serving.result(PATIENCE_S)


def request(body: bytes, path: str = "/") -> bytes:
    return f"POST {path} HTTP/1.1\r\nHost: x\r\nContent-Length: {len(body)}\r\n\r\n".encode() + body


def reply(connection: socket.socket) -> bytes:
    """The body of the next reply."""
    with connection.makefile("rb", buffering=0) as file:
        return reply_in(file)[1]


def reply_in(file: IO[bytes]) -> tuple[int, bytes]:
    status, length = int(file.readline().split()[1]), 0
    while (line := file.readline()) != b"\r\n":
        assert line, "the connection was closed"
        name, _, value = line.lower().partition(b": ")
        if name == b"content-length":
            length = int(value)
    content = b""
    while len(content) < length:
        content += file.read(length - len(content)) or b""
    return status, content


def status_of(sent: bytes) -> int:
    with served() as connect, connect().makefile("rwb", buffering=0) as file:
        file.write(sent)
        return reply_in(file)[0]


def test_many_silent_connections_and_some_that_speak() -> None:
    with served() as connect:
        everybody = [connect() for _ in range(200)]
        for _ in range(2):
            for number in (3, 150, 3):
                everybody[number].sendall(request(str(number).encode()))
                assert reply(everybody[number]) == str(number).encode()
        for number, connection in enumerate(everybody):
            connection.sendall(request(str(number).encode()))
        for number, connection in enumerate(everybody):
            assert reply(connection) == str(number).encode()


def test_requests_that_come_before_the_reply_are_answered_in_order() -> None:
    with served() as connect:
        connection = connect()
        connection.sendall(b"".join(request(str(number).encode()) for number in range(30)))
        connection.sendall(request(b"last"))
        assert [reply(connection) for _ in range(31)] == [
            *(str(number).encode() for number in range(30)),
            b"last",
        ]


def test_bodies_that_come_slowly_occupy_no_thread() -> None:
    with served() as connect:
        slow = [connect() for _ in range(3 * THREADS)]
        sent = request(b"in pieces")
        for connection in slow:
            connection.sendall(sent[:-4])
        quick = connect()
        quick.sendall(request(b"quick"))
        assert reply(quick) == b"quick"
        for connection in slow:
            connection.sendall(sent[-4:])
        assert [reply(connection) for connection in slow] == [b"in pieces"] * len(slow)


def test_large_replies_that_are_read_late_occupy_no_thread() -> None:
    CLOSED.clear()
    with served() as connect:
        late = [connect() for _ in range(3 * THREADS)]
        for connection in late:
            connection.sendall(request(b"", "/large"))
        time.sleep(0.5)
        quick = connect()
        quick.sendall(request(b"quick"))
        assert reply(quick) == b"quick"
        for connection in late[1:]:
            assert reply(connection) == b"x" * LARGE
            connection.sendall(request(b"again"))
            assert reply(connection) == b"again"
        late[0].close()
    assert ["large"] * len(late) == CLOSED


def test_connections_that_break() -> None:
    with served() as connect:
        for path in ("/", "/large"):
            gone = connect()
            gone.sendall(request(b"never read", path))
            gone.close()
        half = connect()
        half.sendall(b"POST / HTTP/1.1\r\nContent-")
        half.close()
        there = connect()
        there.sendall(request(b"there"))
        assert reply(there) == b"there"


@pytest.mark.parametrize(
    ("sent", "status"),
    [
        (b"nonsense\r\n\r\n", 400),
        (b"POST / HTTP/1.1\r\nHost: x\r\nContent-Length: -1\r\n\r\n", 400),
        (b"POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 1001\r\n\r\n", 413),
        (
            b"POST / HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n"
            b"3e9\r\n" + b"x" * 1001 + b"\r\n0\r\n\r\n",
            413,
        ),
        (b"GET / HTTP/1.1\r\nX: " + b"x" * 10**6 + b"\r\n\r\n", 431),
        (b"GET /fail HTTP/1.1\r\nHost: x\r\n\r\n", 500),
    ],
)
def test_what_is_refused(sent: bytes, status: int) -> None:
    assert status_of(sent) == status


def test_a_request_as_the_app_sees_it() -> None:
    with served() as connect:
        connection = connect()
        connection.sendall(
            b"GET /environ?a=%20b HTTP/1.1\r\nHost: x\r\nX-Forwarded-For: 1\r\n"
            b"X-Forwarded-For: 2\r\nX_Forwarded_For: 3\r\n"
            b"Cookie: a=1\r\nCookie: b=2\r\nX-Other: \xff\r\n\r\n"
        )
        environ = json.loads(reply(connection))
    assert environ["QUERY_STRING"] == "a=%20b"
    assert environ["REMOTE_ADDR"] == "127.0.0.1"
    assert environ["HTTP_X_FORWARDED_FOR"] == "1,2"
    assert environ["HTTP_COOKIE"] == "a=1; b=2"


def test_the_head_of_a_request_must_come_soon() -> None:
    with served(head_s=0.5) as connect:
        silent, begun, begins_again, sends = (connect() for _ in range(4))
        begun.sendall(b"POST / HTTP/1.1\r\nHost:")
        begins_again.sendall(request(b"first"))
        assert reply(begins_again) == b"first"
        begins_again.sendall(b"POST / HTTP/1.1\r\nHost:")
        sent = request(b"a body may take longer")
        sends.sendall(sent[:-5])
        for connection in (silent, begun, begins_again):
            assert connection.recv(1) == b""
        sends.sendall(sent[-5:])
        assert reply(sends) == b"a body may take longer"


@pytest.fixture
def many_files() -> Iterator[None]:
    """Each connection is one."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, min(hard, 8192)), hard))
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


@pytest.mark.slow
@pytest.mark.usefixtures("many_files")
def test_the_server_itself_with_a_thousand_unfinished_requests(
    app: Flask, config: Config, tmp_path: Path
) -> None:
    person = Browser(app)
    item = person.take("describe")["item"]
    with running(config, tmp_path) as server, ExitStack() as opened:
        for _ in range(1010):
            one = opened.enter_context(socket.create_connection(("127.0.0.1", server.port)))
            one.sendall(b"GET / HTTP/1.1\r\nX: ")
        for number in range(20):
            client = server.client(person)
            client.connection.source_address = (f"127.0.0.{2 + number % 3}", 0)
            start = time.monotonic()
            status, content, _ = client.answer(item, described(), new_uuid())
            assert (status, content["state"]) == (200, "repeated" if number else "accepted")
            assert time.monotonic() - start < 1
        assert server.end() == 0
