"""The server's connections: many that are silent, slow, broken, or more than it takes."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest
import waitress

from annotation_app.connections import Connections

LARGE = 4_000_000
PATIENCE_S = 60.0


def echo(environ: dict[str, Any], start_response: Callable[..., Any]) -> Iterable[bytes]:
    """Reply with what was sent, or with much."""
    body = environ["wsgi.input"].read()
    if environ["PATH_INFO"] == "/large":
        body = b"x" * LARGE
    start_response("200 OK", [("Content-Length", str(len(body)))])
    return [body]


@contextmanager
def served(**options: Any) -> Iterator[Callable[[], socket.socket]]:
    """What connects to a server."""
    connections = Connections()
    is_over = False
    server = waitress.create_server(
        echo, map=connections, host="127.0.0.1", port=0, threads=2, **options
    )

    def serve() -> None:
        while not is_over:
            connections.wait(0.05)

    thread = threading.Thread(target=serve)
    thread.start()
    opened: list[socket.socket] = []

    def connect() -> socket.socket:
        opened.append(socket.create_connection(("127.0.0.1", server.effective_port), PATIENCE_S))
        return opened[-1]

    try:
        yield connect
    finally:
        is_over = True
        thread.join()
        server.task_dispatcher.shutdown()
        for connection in list(connections.values()):
            connection.handle_close()
        for connection in opened:
            connection.close()


def request(body: bytes, path: str = "/") -> bytes:
    return f"POST {path} HTTP/1.1\r\nHost: x\r\nContent-Length: {len(body)}\r\n\r\n".encode() + body


def reply(connection: socket.socket) -> bytes:
    """The body of the next reply."""
    with connection.makefile("rb", buffering=0) as file:
        length = 0
        while (line := file.readline()) != b"\r\n":
            assert line, "the connection was closed"
            name, _, value = line.partition(b": ")
            if name == b"Content-Length":
                length = int(value)
        found = b""
        while len(found) < length:
            found += file.read(length - len(found)) or b""
        return found


def test_many_silent_connections_and_some_that_speak() -> None:
    with served(connection_limit=1000) as connect:
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


def test_a_body_that_comes_in_pieces_and_a_large_reply_that_is_read_late() -> None:
    with served() as connect:
        slow, late, quick = connect(), connect(), connect()
        late.sendall(request(b"", "/large"))
        sent = request(b"in pieces")
        slow.sendall(sent[:-4])
        quick.sendall(request(b"quick"))
        assert reply(quick) == b"quick"
        slow.sendall(sent[-4:])
        assert reply(slow) == b"in pieces"
        assert len(reply(late)) == LARGE
        late.sendall(request(b"again"))
        assert reply(late) == b"again"


def test_connections_that_break() -> None:
    with served() as connect:
        for path in ("/", "/large"):
            gone = connect()
            gone.sendall(request(b"never read", path))
            gone.close()
        half = connect()
        half.sendall(b"POST / HTTP/1.1\r\nContent-")
        half.close()
        wrong = connect()
        wrong.sendall(b"nonsense\r\n\r\n")
        assert b"Bad Request" in reply(wrong)
        assert wrong.recv(1) == b""
        there = connect()
        there.sendall(request(b"there"))
        assert reply(there) == b"there"


def test_what_is_too_large_is_refused() -> None:
    with served(max_request_body_size=1000) as connect:
        connection = connect()
        connection.sendall(b"POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 1001\r\n\r\n")
        assert b"Request Entity Too Large" in reply(connection)


def test_more_connections_than_it_takes_wait() -> None:
    # The one that listens and the bell count as well.
    with served(connection_limit=4) as connect:
        first, second, third = connect(), connect(), connect()
        for connection in (first, second):
            connection.sendall(request(b"here"))
            assert reply(connection) == b"here"
        third.sendall(request(b"waits"))
        third.settimeout(0.2)
        with pytest.raises(TimeoutError):
            third.recv(1)
        third.settimeout(PATIENCE_S)
        first.close()
        assert reply(third) == b"waits"


def test_silent_connections_are_closed_in_the_end() -> None:
    with served(channel_timeout=0, cleanup_interval=0) as connect:
        assert connect().recv(1) == b""
