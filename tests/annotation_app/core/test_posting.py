"""Where something may be sent, and what becomes of it."""

from __future__ import annotations

import socket
import threading

import pytest

from annotation_app.core import posting
from annotation_app.core.posting import PostProblem, addresses_of, check_address, is_public, post


@pytest.mark.parametrize(
    "address",
    [
        *("127.0.0.1", "10.1.2.3", "172.16.0.1", "192.168.1.1", "169.254.169.254", "0.0.0.0"),
        *("100.64.0.1", "224.0.0.1", "255.255.255.255", "::1", "::", "fe80::1%eth0", "fc00::1"),
        *("::ffff:127.0.0.1", "::ffff:10.0.0.1", "2002:7f00:1::", "64:ff9b::a00:1", "ff02::1"),
    ],
)
def test_private_addresses(address: str) -> None:
    assert not is_public(address)


@pytest.mark.parametrize("address", ["93.184.216.34", "2606:2800:220:1::1", "64:ff9b::5db8:d822"])
def test_public_addresses(address: str) -> None:
    assert is_public(address)


@pytest.mark.parametrize(
    "url",
    [
        *("", "lab.example.org", "ftp://lab.example.org", "file:///etc/passwd", "https://"),
        *("https://me:secret@lab.example.org", "https://lab.example.org/#x", "https://[::1"),
        *("https://lab.example.org:0", "https://lab.example.org:99999", "https://lab/a b"),
        *("https://lab.example.org/\r\nX: y", "https://l\u00e4b.example.org", "gopher://x"),
    ],
)
def test_what_is_no_address(url: str) -> None:
    for allows_private in (True, False):
        with pytest.raises(PostProblem, match="no address"):
            check_address(url, allows_private=allows_private)


def test_tls_is_needed_unless_private_places_are_allowed() -> None:
    with pytest.raises(PostProblem, match="https"):
        check_address("http://lab.example.org", allows_private=False)
    assert check_address("http://lab.example.org", allows_private=True).hostname


@pytest.mark.parametrize(
    "host", ["localhost", "127.0.0.1", "[::1]", "0", "2130706433", "0x7f.1", "[::ffff:127.0.0.1]"]
)
def test_no_writing_of_a_private_address_is_taken(host: str) -> None:
    parts = check_address(f"https://{host}/", allows_private=False)
    with pytest.raises(PostProblem, match=r"private|known"):
        addresses_of(parts, allows_private=False)


def test_a_slow_answer_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(posting, "LONGEST_S", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as server:

        def drip() -> None:
            connection, _ = server.accept()
            with connection:
                for _ in range(100):
                    try:
                        connection.sendall(b"H")
                    except OSError:
                        return
                    threading.Event().wait(0.05)

        thread = threading.Thread(target=drip)
        thread.start()
        with pytest.raises(PostProblem):
            post(f"http://127.0.0.1:{server.getsockname()[1]}", b"{}", {}, allows_private=True)
        thread.join()


def test_tls_is_checked() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]

        def answer() -> None:
            connection, _ = server.accept()
            with connection:
                connection.recv(1000)
                connection.sendall(b"this is no TLS")

        thread = threading.Thread(target=answer)
        thread.start()
        with pytest.raises(PostProblem, match="TLS"):
            post(f"https://127.0.0.1:{port}", b"{}", {}, allows_private=True)
        thread.join()
