"""Run Firefox for Playwright, and answer the one command that its releases don't know.

Playwright drives installed Firefox by WebDriver BiDi. From 1.59 on it sends, for every new
context, ``emulation.setMediaFeaturesOverride``, even when no feature is to be overridden; Firefox
153 answers "unknown command", and no context can be made. This relay stands between the two. It
answers that command where Firefox is as it asks already (light, by `PREFERENCES`), and passes
everything else on. A test that asks for a dark scheme in Firefox still fails, as it should.
"""

from __future__ import annotations

import asyncio
import json
import re
import sys
from asyncio.subprocess import PIPE, Process
from contextlib import suppress
from typing import Any

from websockets.asyncio.client import ClientConnection, connect
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed

UNKNOWN = "emulation.setMediaFeaturesOverride"
PREFERENCES = {"layout.css.prefers-color-scheme.content-override": 1, "ui.prefersReducedMotion": 1}
"""Light, and without motion, of which Playwright tells Firefox nothing."""
LISTENS = re.compile(r"(WebDriver BiDi listening on )(ws://\S+)")


def answer_to(message: str) -> str | None:
    """Return the answer to an override by what is, or None for what Firefox is to answer."""
    if UNKNOWN not in message:
        return None
    command: dict[str, Any] = json.loads(message)
    if command["method"] != UNKNOWN:
        return None
    if not {None, "light"}.issuperset(command["params"]["features"].values()):
        return None
    return json.dumps({"type": "success", "id": command["id"], "result": {}})


async def pass_on(near: ServerConnection, address: str) -> None:
    """Connect Playwright with Firefox until one of them goes."""

    async def send(browser: ClientConnection) -> None:
        async for message in near:
            answer = answer_to(str(message))
            await (browser.send(message) if answer is None else near.send(answer))

    async def receive(browser: ClientConnection) -> None:
        async for message in browser:
            await near.send(message)

    path = near.request.path if near.request else ""
    async with connect(address + path, max_size=None, compression=None) as browser:
        ways = [asyncio.create_task(way(browser)) for way in (send, receive)]
        _, others = await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
        for way in others:
            way.cancel()
        await asyncio.gather(*ways, return_exceptions=True)


async def watch(firefox: Process) -> None:
    """Repeat what Firefox writes, with the relay's address for its own."""
    assert firefox.stderr is not None
    async for line in firefox.stderr:
        text = line.decode(errors="replace")
        if match := LISTENS.search(text):
            address = match[2]

            async def handle(near: ServerConnection, address: str = address) -> None:
                with suppress(ConnectionClosed):
                    await pass_on(near, address)

            server = await serve(handle, "127.0.0.1", 0, max_size=None, compression=None)
            port = server.sockets[0].getsockname()[1]
            text = LISTENS.sub(rf"\g<1>ws://127.0.0.1:{port}", text)
        sys.stderr.write(text)
        sys.stderr.flush()


async def main() -> int:
    """Start Firefox with what follows the module's name, and return its exit status."""
    firefox = await asyncio.create_subprocess_exec(*sys.argv[1:], stderr=PIPE)
    await watch(firefox)
    return await firefox.wait()


if __name__ == "__main__":
    sys.exit(asyncio.run(main()))
