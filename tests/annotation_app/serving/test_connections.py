"""The server's connections: many that are silent, slow, broken, or more than it takes."""

from __future__ import annotations

import resource
import socket
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest
import waitress
from flask import Flask

from annotation_app.core.config import Config
from annotation_app.serving.connections import Connections, Room, network_of
from tests.annotation_app.browser import Browser, described
from tests.annotation_app.real_server import new_uuid, running

LARGE = 4_000_000
PATIENCE_S = 60.0


def echo(environ: dict[str, Any], start_response: Callable[..., Any]) -> Iterable[bytes]:
    """Reply with what was sent, or with much."""
    body = environ["wsgi.input"].read()
    if environ["PATH_INFO"] == "/large":
        body = b"x" * LARGE
    elif environ["PATH_INFO"] == "/slow":
        time.sleep(1.0)
    start_response("200 OK", [("Content-Length", str(len(body)))])
    return [body]


@contextmanager
def served(room: Room | None = None, **options: Any) -> Iterator[Callable[..., socket.socket]]:
    """What connects to a server, from an address of this machine."""
    connections = Connections(room)
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

    def connect(address: str = "127.0.0.1") -> socket.socket:
        there, here = ("127.0.0.1", server.effective_port), (address, 0)
        opened.append(socket.create_connection(there, PATIENCE_S, source_address=here))
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
    with served(Room(idle_s=0)) as connect:
        assert connect().recv(1) == b""


def test_the_head_of_a_request_must_come_soon() -> None:
    with served(Room(head_s=0.5)) as connect:
        silent, begun, begins_again, waits, sends = (connect() for _ in range(5))
        begun.sendall(b"POST / HTTP/1.1\r\nHost:")
        for connection in (begins_again, waits):
            connection.sendall(request(b"first"))
            assert reply(connection) == b"first"
        begins_again.sendall(b"POST / HTTP/1.1\r\nHost:")
        sent = request(b"a body may take longer")
        sends.sendall(sent[:-5])
        for connection in (silent, begun, begins_again):
            assert connection.recv(1) == b""
        sends.sendall(sent[-5:])
        assert reply(sends) == b"a body may take longer"
        waits.sendall(request(b"second"))
        assert reply(waits) == b"second"


def test_unfinished_heads_of_one_client_shut_nobody_out() -> None:
    # Nobody waits until heads that never end are given up.
    with served(Room(200, head_s=10 * PATIENCE_S), connection_limit=300) as connect:
        for _ in range(1010):
            connect("127.0.0.1").sendall(b"GET / HTTP/1.1\r\nX: ")
        for address in ("127.0.0.2", "127.0.0.1"):
            other = connect(address)
            other.sendall(request(b"let me in"))
            assert reply(other) == b"let me in"


@pytest.mark.parametrize("is_done", [True, False])
def test_who_has_most_connections_gives_one_back(is_done: bool) -> None:
    """Whether each has had an answer, or sends its body slowly."""
    with served(Room(30), connection_limit=100) as connect:
        few = [connect(f"127.0.0.{number}") for number in range(2, 12)]
        many = []
        for connection in few:
            connection.sendall(request(b"few"))
            assert reply(connection) == b"few"
        for number in range(100):
            many.append(connect())
            sent = request(b"slow")
            many[-1].sendall(sent if is_done else sent[:-1])
            if is_done:
                assert reply(many[-1]) == b"slow"
            elif number % 10 == 0:
                few[0].sendall(request(b"meanwhile"))
                assert reply(few[0]) == b"meanwhile"
        for connection in few:
            connection.sendall(request(b"still here"))
            assert reply(connection) == b"still here"
        assert many[0].recv(1) == b""  # its oldest


def test_nobody_is_sent_away_while_they_are_answered(caplog: pytest.LogCaptureFixture) -> None:
    with served(Room(6), connection_limit=100) as connect:
        answered = []
        for _ in range(6):  # one after the other: half of the room may be without a request
            answered.append(connect())
            answered[-1].sendall(request(b"x", "/slow"))
        silent = connect()
        for _ in range(10):  # each takes the place of the one before
            before, silent = silent, connect()
            assert before.recv(1) == b""
        silent.sendall(request(b"y", "/slow"))
        assert [reply(connection) for connection in (*answered, silent)] == [b"x"] * 6 + [b"y"]
    room = "annotation_app.serving.connections"
    told = [r.getMessage() for r in caplog.records if r.name == room]
    assert told == [
        "all 6 connections are in use, 8 of them by one address; "
        "those that wait for longest are closed"
    ]


def test_the_network_of_an_ipv6_address_counts() -> None:
    assert network_of("192.0.2.1") == "192.0.2.1"
    assert network_of("2001:db8:1::1") == network_of("2001:db8:1:0:ffff::2%eth0")
    assert network_of("2001:db8:1::1") != network_of("2001:db8:2::1")


def test_who_never_reads_their_answers_gives_room_to_others() -> None:
    with served(Room(3), connection_limit=100) as connect:
        for _ in range(3):
            connect().sendall(request(b"", "/large"))
        time.sleep(2.5)
        for address in ("127.0.0.2", "127.0.0.3", "127.0.0.4"):
            other = connect(address)
            other.sendall(request(b"let me in"))
            assert reply(other) == b"let me in"


@pytest.fixture
def many_files() -> Iterator[None]:
    """Each connection is one."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, min(hard, 4096)), hard))
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
            status, reply, _ = client.answer(item, described(), new_uuid())
            assert (status, reply["state"]) == (200, "repeated" if number else "accepted")
        assert server.end() == 0
    assert server.logged() == []
