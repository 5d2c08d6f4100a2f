"""A server that speaks the protocol of chat completions, for tests. It thinks by simple rules.

It is no language model: what it says of a command is the first liftable thing whose last label
occurs in it. It counts all requests, and fails as it is told to.
"""

from __future__ import annotations

import json
import re
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

Fault = Callable[[int], "tuple[int, str] | None"]
"""From how often a request has come (1 for the first time) to a status and a body to fail with."""


def answer(body: dict[str, Any]) -> str:
    """A plan or a verdict."""
    asked = body["messages"][1]["content"]
    world = json.loads(re.search(r"World: (.*)\n", asked)[1])
    text = re.search(r"Command: (.*)", asked)[1].lower()
    if body["messages"][0]["content"].startswith("You judge"):
        return json.dumps({"correct": "was picked up" in asked, "reason": "nothing was moved"})
    loads = [t for t in world["things"] if t.get("liftable")]
    named = [t for t in loads if any(label in text for label in t["labels"])]
    if not named:
        return json.dumps({"actions": [], "reason": "no load is named"})
    step = {"action": "pick up", "object": named[0]["id"]}
    return json.dumps({"actions": [step], "probability": 0.75, "reason": "it is named"})


@dataclass
class Chat:
    """What the server has seen.

    Parameters
    ----------
    url
        Where it is.
    seen
        How often each request came.
    answered
        How often each was answered with status 200, all of which have to be paid.
    most_at_once
        How many requests were under way at the same time, at most.
    together
        Nobody is answered before so many requests are under way.
    """

    url: str = ""
    seen: Counter[str] = field(default_factory=Counter)
    answered: Counter[str] = field(default_factory=Counter)
    headers: list[dict[str, str]] = field(default_factory=list)
    bodies: list[dict[str, Any]] = field(default_factory=list)
    most_at_once: int = 0
    delay_s: float = 0.0
    together: int = 0
    fault: Fault = lambda count: None
    says: Callable[[dict[str, Any]], str] = answer
    _under_way: int = 0
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def takes(self, body: bytes, headers: dict[str, str]) -> int:
        with self._lock:
            self.seen[body.decode()] += 1
            self.headers.append(headers)
            self.bodies.append(json.loads(body))
            self._under_way += 1
            self.most_at_once = max(self.most_at_once, self._under_way)
            return self.seen[body.decode()]

    def leaves(self, body: bytes, *, answered: bool) -> None:
        with self._lock:
            self._under_way -= 1
            if answered:
                self.answered[body.decode()] += 1


class _Server(ThreadingHTTPServer):
    daemon_threads = True

    def handle_error(self, request: object, client_address: object) -> None:
        pass  # clients that are killed hang up


@contextmanager
def chat_server(**settings: Any) -> Iterator[Chat]:
    """A running server."""
    chat = Chat(**settings)
    barrier = threading.Barrier(chat.together or 1)

    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def do_POST(self) -> None:
            length = int(self.headers["Content-Length"])
            body = self.rfile.read(length)
            if len(body) < length:  # its sender was killed: nothing was asked
                return
            self.paid = False
            count = chat.takes(body, {k.lower(): v for k, v in self.headers.items()})
            try:
                self._answer(body, count)
            finally:
                chat.leaves(body, answered=self.paid)

        def _answer(self, body: bytes, count: int) -> None:
            if not self.path.endswith("/chat/completions"):
                self._reply(404, json.dumps({"error": {"message": "no such path"}}))
                return
            time.sleep(chat.delay_s)
            barrier.wait(timeout=60)
            fault = chat.fault(count)
            if fault:
                self._reply(*fault)
                return
            self.paid = True  # whether or not the reply arrives
            self._reply(200, _completion(json.loads(body), chat))

        def _reply(self, status: int, content: str) -> None:
            if status == 0:  # hang up
                self.close_connection = True
                return
            sent = content.encode()
            self.send_response(status)
            self.send_header("Content-Type", "application/json")
            self.send_header("Content-Length", str(len(sent)))
            if status == 429:
                self.send_header("Retry-After", "0.05")
            self.end_headers()
            self.wfile.write(sent)

        def log_message(self, format: str, *args: object) -> None:
            pass

    server = _Server(("127.0.0.1", 0), Handler)
    chat.url = f"http://127.0.0.1:{server.server_address[1]}/v1"
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield chat
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


def _completion(body: dict[str, Any], chat: Chat) -> str:
    text = chat.says(body)
    return json.dumps(
        {
            "id": "chatcmpl-1",
            "object": "chat.completion",
            "created": 1,
            "model": f"{body['model']}-2026",
            "system_fingerprint": "fp_test",
            "choices": [
                {
                    "index": 0,
                    "finish_reason": "stop",
                    "message": {"role": "assistant", "content": text},
                }
            ],
            "usage": {"prompt_tokens": 1000, "completion_tokens": 20, "total_tokens": 1020},
        }
    )
