"""A WSGI app behind Granian, with clients that may be slow.

Granian receives and sends without Python. In its own WSGI interface, however, each request that
comes slowly and each reply that is read slowly occupies a thread. Here threads only compute.
"""

from __future__ import annotations

import asyncio
import io
import logging
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from contextvars import copy_context
from typing import TYPE_CHECKING, Any

from granian.rsgi import HTTPProtocol, ProtocolClosed, ProtocolError, Scope
from werkzeug.wsgi import FileWrapper

if TYPE_CHECKING:
    from _typeshed.wsgi import WSGIApplication, WSGIEnvironment

log = logging.getLogger(__name__)

SILENCE_S = 60.0
"""Longest wait for more of a request's body, or until more of a reply is taken, in seconds."""
PART = 2**18
"""Size from which a reply is sent in parts, in bytes."""
GONE = (ProtocolClosed, ProtocolError, asyncio.TimeoutError)
"""Exceptions where a client has gone, or may as well have."""


class Gateway:
    """An RSGI app that answers with a WSGI app.

    Parameters
    ----------
    threads
        Number of requests that are answered at the same time; others wait.
    body_bytes
        Largest body of a request; larger ones are refused with status 413.
    """

    def __init__(self, app: WSGIApplication, *, threads: int, body_bytes: int) -> None:
        self._app = app
        self._body_bytes = body_bytes
        self._threads = ThreadPoolExecutor(threads, thread_name_prefix="request")
        self.listens = asyncio.Event()

    def __rsgi_init__(self, loop: asyncio.AbstractEventLoop) -> None:
        """Note that a server begins; it listens as soon as this returns."""
        loop.call_soon(self.listens.set)

    async def __rsgi__(self, scope: Scope, protocol: HTTPProtocol) -> None:
        """Answer a request."""
        loop = asyncio.get_running_loop()
        run: Callable[..., None] = copy_context().run

        def compute(*call: Any) -> asyncio.Future[None]:
            return loop.run_in_executor(self._threads, run, *call)

        with suppress(*GONE):
            body = await self._body(scope, protocol)
            if isinstance(body, int):
                _refuse(protocol, body)
                return
            reply = _Reply()
            try:
                await compute(reply.begin, self._app, _environ(scope, body))
                if len(reply.part) < PART:
                    protocol.response_bytes(reply.status, reply.headers, reply.part)
                    return
                stream = protocol.response_stream(reply.status, reply.headers)
                while reply.part:
                    await asyncio.wait_for(stream.send_bytes(reply.part), SILENCE_S)
                    await compute(reply.take_part)
            except GONE:
                raise
            except Exception:
                log.exception("a request failed")
                _refuse(protocol, 500)
            finally:
                reply.close()

    async def _body(self, scope: Scope, protocol: HTTPProtocol) -> bytes | int:
        """Return a request's body, or the status of its refusal."""
        if int(scope.headers.get("content-length") or 0) > self._body_bytes:
            return 413
        parts = protocol.__aiter__()
        body = bytearray()
        while len(body) <= self._body_bytes:
            try:
                body += await asyncio.wait_for(parts.__anext__(), SILENCE_S)
            except StopAsyncIteration:
                return bytes(body)
        return 413


def _refuse(protocol: HTTPProtocol, status: int) -> None:
    headers = [("content-type", "text/plain"), ("connection", "close")]
    protocol.response_str(status, headers, f"{status}\n")


class _Reply:
    """A WSGI app's reply, of which a part has been taken; the last one is empty or short."""

    def __init__(self) -> None:
        self.status = 500
        self.headers: list[tuple[str, str]] = []
        self.part = b""
        self.close: Callable[[], object] = bool

    def begin(self, app: WSGIApplication, environ: WSGIEnvironment) -> None:
        content = app(environ, self._start)
        self.close = getattr(content, "close", bool)
        self._pieces = iter(content)
        self.take_part()

    def take_part(self) -> None:
        part = bytearray()
        for piece in self._pieces:
            part += piece
            if len(part) >= PART:
                break
        self.part = bytes(part)

    def _start(self, status: str, headers: list[tuple[str, str]], _error: Any = None) -> Any:
        self.status, self.headers = int(status[:3]), headers


def _environ(scope: Scope, body: bytes) -> WSGIEnvironment:
    """Return a request as PEP 3333 has it."""
    host, _, port = scope.server.rpartition(":")
    headers: dict[str, str] = {}
    for name, value in scope.headers.items():
        if "_" not in name:  # else another name could pass for it
            joint = "; " if name == "cookie" else ","
            headers[name] = f"{headers[name]}{joint}{value}" if name in headers else value
    return {
        **{f"HTTP_{name.upper().replace('-', '_')}": value for name, value in headers.items()},
        "REQUEST_METHOD": scope.method,
        "SCRIPT_NAME": "",
        "PATH_INFO": scope.path.encode().decode("latin-1"),
        "QUERY_STRING": scope.query_string,
        "CONTENT_TYPE": headers.get("content-type", ""),
        "CONTENT_LENGTH": str(len(body)),
        "SERVER_NAME": host.strip("[]"),
        "SERVER_PORT": port,
        "SERVER_PROTOCOL": f"HTTP/{scope.http_version}",
        "REMOTE_ADDR": scope.client.rpartition(":")[0].strip("[]"),
        "wsgi.version": (1, 0),
        "wsgi.url_scheme": scope.scheme,
        "wsgi.input": io.BytesIO(body),
        "wsgi.errors": sys.stderr,
        "wsgi.multithread": True,
        "wsgi.multiprocess": False,
        "wsgi.run_once": False,
        "wsgi.file_wrapper": lambda file, _size=0: FileWrapper(file, PART),
    }
