"""Sending something to an address that somebody has named, and to no other.

Names are looked up once, and the connection goes to an address that was looked at: a name that
leads elsewhere a moment later gains nothing. Addresses of the machine itself and of private
networks are refused unless they are allowed. Redirects aren't followed, proxies that the
environment names aren't used, and nothing of the reply but its status is read.
"""

from __future__ import annotations

import http.client
import ipaddress
import socket
import ssl
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from urllib.parse import SplitResult, urlsplit

TIMEOUT_S = 10.0
"""How long each step may take."""
LONGEST_S = 20.0
"""How long all of it may take, however slowly an answer drips."""
PRIVATE, NO_TLS = "the address is private", "the address must begin with https://"
_NAT64 = ipaddress.IPv6Network("64:ff9b::/96")


class PostProblem(Exception):  # noqa: N818 - it is no bug, it is what others' servers do
    """Why something didn't arrive, in a few words."""


def check_address(url: str, *, allows_private: bool) -> SplitResult:
    """Read an address; whether it leads into a private network isn't known yet.

    A PostProblem says that it isn't one, or isn't protected by TLS where that is needed.
    """
    try:
        parts = urlsplit(url)
        named = parts.scheme in ("http", "https") and parts.hostname and parts.port != 0
    except ValueError:
        named = False
    if not named or parts.username or parts.password or parts.fragment or not _is_plain(url):
        raise PostProblem("this is no address of a web server")
    if parts.scheme != "https" and not allows_private:
        raise PostProblem(NO_TLS)
    return parts


def addresses_of(parts: SplitResult, *, allows_private: bool) -> list[str]:
    """Where a name leads to.

    A PostProblem says that it leads nowhere, or to somewhere private.
    """
    try:
        found = socket.getaddrinfo(parts.hostname, _port(parts), type=socket.SOCK_STREAM)
    except (OSError, UnicodeError) as error:
        raise PostProblem("the name isn't known") from error
    addresses = list(dict.fromkeys(str(info[4][0]) for info in found))
    if not allows_private and not all(map(is_public, addresses)):
        raise PostProblem(PRIVATE)
    return addresses


def is_public(address: str) -> bool:
    """Whether an IP address is one of the Internet's, also as it is written inside another one."""
    found = ipaddress.ip_address(address.partition("%")[0])
    if isinstance(found, ipaddress.IPv6Address):
        inner = found.ipv4_mapped or found.sixtofour
        if found in _NAT64:
            inner = ipaddress.IPv4Address(int(found) & 0xFFFFFFFF)
        if inner is not None:
            return is_public(str(inner))
        if found.teredo is not None:
            return False
    return found.is_global and not found.is_multicast


def post(url: str, content: bytes, headers: Mapping[str, str], *, allows_private: bool) -> None:
    """Send something; done when the server has said that it has it.

    A PostProblem says that it isn't sure that it has it.
    """
    parts = check_address(url, allows_private=allows_private)
    addresses = addresses_of(parts, allows_private=allows_private)
    path = f"{parts.path or '/'}{f'?{parts.query}' if parts.query else ''}"
    try:
        with _connected(parts, addresses) as connection:
            connection.request("POST", path, content, dict(headers))
            status = connection.getresponse().status
    except TimeoutError as error:
        raise PostProblem("no answer in time") from error
    except ssl.SSLError as error:
        raise PostProblem(f"TLS failed: {error.reason or 'no certificate'}") from error
    except (OSError, http.client.HTTPException, ValueError) as error:
        reason = getattr(error, "strerror", None) or type(error).__name__
        raise PostProblem(f"no connection: {reason}"[:200]) from error
    if not 200 <= status < 300:
        raise PostProblem(f"status {status}")


@contextmanager
def _connected(parts: SplitResult, addresses: list[str]) -> Iterator[http.client.HTTPConnection]:
    host, port = parts.hostname or "", _port(parts)
    made = _first(addresses, port)
    given_up = threading.Timer(LONGEST_S, _cut, [made])
    given_up.daemon = True
    given_up.start()
    connection = http.client.HTTPConnection(host, port, timeout=TIMEOUT_S)
    try:
        if parts.scheme == "https":
            made = ssl.create_default_context().wrap_socket(made, server_hostname=host)
            made.settimeout(TIMEOUT_S)
        connection.sock = made
        yield connection
    finally:
        given_up.cancel()
        connection.close()
        made.close()


def _first(addresses: list[str], port: int) -> socket.socket:
    """A connection to the first address that takes one."""
    problem: OSError = OSError("there is no address")
    for address in addresses:
        try:
            return socket.create_connection((address, port), TIMEOUT_S)
        except OSError as error:
            problem = error
    raise problem


def _cut(made: socket.socket) -> None:
    with suppress(OSError):  # it is closed already
        made.shutdown(socket.SHUT_RDWR)


def _port(parts: SplitResult) -> int:
    return parts.port or (443 if parts.scheme == "https" else 80)


def _is_plain(url: str) -> bool:
    return url.isascii() and all(character.isprintable() and character != " " for character in url)
