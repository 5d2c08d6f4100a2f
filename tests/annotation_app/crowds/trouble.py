"""Platforms in this process whose calls go wrong, and programs that are killed."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, get_args

import boto3
import httpx
from botocore.awsrequest import AWSResponse
from botocore.config import Config as BotoConfig
from botocore.exceptions import ConnectionClosedError, EndpointConnectionError, ReadTimeoutError
from sqlalchemy import Engine, event

from tests.annotation_app.crowds.prolific_stand_in import Prolific, operation_of
from tests.annotation_app.crowds.stand_ins import MechanicalTurk

Kind: TypeAlias = Literal[
    "not sent",
    "refused",
    "no answer, done",
    "no answer, not done",
    "error, done",
    "error, not done",
    "killed before the call",
    "killed after the call",
    "killed at a commit",
]
KINDS: tuple[Kind, ...] = get_args(Kind)


AT_COMMIT: Kind = "killed at a commit"
Target: TypeAlias = Literal["offer", "approve", "set up", "pay"]


class Killed(BaseException):
    """The program ends here, whatever it was doing."""


class NotSentError(Exception):
    """The network knows no way."""


class NoAnswerError(Exception):
    """The request was sent, and nothing comes back."""


@dataclass
class Trouble:
    """What goes wrong next: the `at`-th call of a sort, or the `at`-th commit."""

    kind: Kind | None = None
    target: Target = "pay"
    at: int = 0
    calls: int = 0
    commits: int = 0

    def reply(self, platform: Any, sort: Target | None, *request: Any) -> tuple[int, Any]:
        """Let a platform answer, unless something goes wrong. Only looking is of no sort."""
        if sort != self.target:
            return _answered(platform(*request))
        number, self.calls = self.calls, self.calls + 1
        kind = self.kind if number == self.at else None
        if kind == "killed before the call":
            raise Killed
        if kind == "not sent":
            raise NotSentError
        if kind == "no answer, not done":
            raise NoAnswerError
        if kind == "refused":
            return 429, {"__type": "ThrottlingException", "Message": "too many requests"}
        if kind == "error, not done":
            return 503, {}
        answer = _answered(platform(*request))
        if kind == "killed after the call":
            raise Killed
        if kind == "no answer, done":
            raise NoAnswerError
        return (502, {}) if kind == "error, done" else answer

    def commit(self, _connection: Any) -> None:
        """Let a transaction be committed, unless the program is killed."""
        number, self.commits = self.commits, self.commits + 1
        if self.kind == "killed at a commit" and number == self.at:
            raise Killed

    @contextmanager
    def happens(self, kind: Kind, target: Target, at: int) -> Iterator[None]:
        """Something goes wrong meanwhile."""
        self.kind, self.target, self.at, self.calls, self.commits = kind, target, at, 0, 0
        event.listen(Engine, "commit", self.commit)
        try:
            yield
        finally:
            event.remove(Engine, "commit", self.commit)
            self.kind = None


AT_PROLIFIC: dict[str, Target | None] = {
    "look": None,
    "approve": "approve",
    "set up": "set up",
    "pay": "pay",
}
AT_MECHANICAL_TURK: dict[str, Target] = {
    "CreateHIT": "offer",
    "ApproveAssignment": "approve",
    "SendBonus": "pay",
}


def prolific_client(platform: Prolific, trouble: Trouble) -> httpx.Client:
    """A client whose requests the platform answers in this process."""

    def answer(request: httpx.Request) -> httpx.Response:
        path = request.url.path
        route = [request.method, *path.strip("/").split("/")[2:]]
        body = request.read()
        operation = operation_of(route, json.loads(body) if body else {})
        headers = {
            "HTTP_AUTHORIZATION": request.headers["Authorization"],
            "QUERY_STRING": request.url.query.decode(),
            "address": "https://prolific.test",
        }
        try:
            status, value = trouble.reply(
                platform, AT_PROLIFIC.get(operation, "offer"), request.method, path, headers, body
            )
        except NotSentError:
            raise httpx.ConnectError("connection refused", request=request) from None
        except NoAnswerError:
            raise httpx.ReadTimeout("timed out", request=request) from None
        return httpx.Response(status, json=value)

    return httpx.Client(
        base_url="https://prolific.test",
        headers={"Authorization": "Token secret"},
        transport=httpx.MockTransport(answer),
    )


def mturk_client(platform: MechanicalTurk, trouble: Trouble) -> Any:
    """A client of boto3's whose requests the platform answers in this process."""
    client = boto3.client(
        "mturk",
        region_name="us-east-1",
        endpoint_url="https://mturk.test",
        config=BotoConfig(retries={"mode": "standard", "total_max_attempts": 1}),
    )

    def answer(request: Any, **_: Any) -> AWSResponse:
        target = request.headers["X-Amz-Target"].decode()
        headers = {
            "HTTP_AUTHORIZATION": request.headers["Authorization"].decode(),
            "HTTP_X_AMZ_TARGET": target,
        }
        sort = AT_MECHANICAL_TURK.get(target.rpartition(".")[2])
        url = request.url
        try:
            status, value = trouble.reply(platform, sort, "POST", "/", headers, request.body)
        except NotSentError:
            raise EndpointConnectionError(endpoint_url=url) from None
        except NoAnswerError:
            lost = ReadTimeoutError if trouble.at % 2 else ConnectionClosedError
            raise lost(endpoint_url=url) from None
        return AWSResponse(url, status, {}, _Body(json.dumps(value).encode()))

    client.meta.events.register("before-send.mturk", answer)
    return client


class _Body(io.BytesIO):
    def stream(self, **_: Any) -> Iterator[bytes]:
        while content := self.read(4096):
            yield content


def _answered(reply: tuple[int, Any] | None) -> tuple[int, Any]:
    assert reply is not None
    return reply
