"""A browser as far as a server under load is concerned, at a fraction of a real client's cost."""

from __future__ import annotations

import asyncio
from typing import Any

import msgspec

Connection = tuple[asyncio.StreamReader, asyncio.StreamWriter]
LOST = (OSError, EOFError, asyncio.TimeoutError)
"""Exceptions of a connection that breaks or takes too long."""


class Client:
    """Sends JSON over connections that are kept open, as many as there are requests at once.

    Parameters
    ----------
    port
        Port of a server on this machine.
    cookie
        Cookie of the session.
    """

    def __init__(self, port: int, cookie: str) -> None:
        self.port = port
        self.cookie = cookie
        self.csrf = ""
        self.idle: list[Connection] = []

    async def request(
        self, method: str, path: str, value: Any, timeout_s: float
    ) -> tuple[int, Any]:
        """Return the status and the JSON of a reply."""
        return await asyncio.wait_for(self._request(method, path, value), timeout_s)

    def close(self) -> None:
        """Close the connections."""
        for _, writer in self.idle:
            writer.close()

    async def _request(self, method: str, path: str, value: Any) -> tuple[int, Any]:
        body = b"" if value is None else msgspec.json.encode(value)
        head = (
            f"{method} {path} HTTP/1.1\r\nHost: localhost\r\nCookie: session={self.cookie}\r\n"
            f"X-CSRFToken: {self.csrf}\r\nContent-Type: application/json\r\n"
            f"Content-Length: {len(body)}\r\n\r\n"
        )
        if self.idle:
            reader, writer = self.idle.pop()
        else:
            reader, writer = await asyncio.open_connection("127.0.0.1", self.port)
        try:
            writer.write(head.encode() + body)
            status, *lines = (await reader.readuntil(b"\r\n\r\n")).decode().split("\r\n")
            headers = dict(line.split(": ", 1) for line in lines if line)
            reply = await reader.readexactly(int(headers["Content-Length"]))
        except BaseException:
            writer.close()
            raise
        self.idle.append((reader, writer))
        if "Set-Cookie" in headers:
            self.cookie = headers["Set-Cookie"].partition(";")[0].partition("=")[2]
        return int(status.split()[1]), msgspec.json.decode(reply)
