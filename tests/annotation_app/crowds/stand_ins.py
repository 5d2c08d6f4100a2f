"""Crowd platforms on this machine: HTTP servers with the operations that are used, and state."""

from __future__ import annotations

import json
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from socketserver import ThreadingMixIn
from typing import Any, Literal, cast
from urllib.parse import parse_qs
from wsgiref.simple_server import WSGIRequestHandler, WSGIServer, make_server

Reply = tuple[int, Any] | None
"""The status, and what is sent as JSON, if anything is; None cuts the connection."""
Loss = Literal["unavailable", "cut", "slow", "never came", "too many"]
"""How an answer is lost: 503, or the connection is cut, or it comes late, each after the request
was carried out; or 503 before that; or a refusal that says that nothing was done."""
LATE_S = 2.0
NOW = 1_790_000_000.0


def lossy(losses: dict[str, Loss], operation: str, reply: Callable[[], Reply]) -> Reply:
    """A reply, unless it is to be lost."""
    loss = losses.pop(operation, None)
    if loss == "too many":
        return 429, {"__type": "ThrottlingException", "Message": "too many requests"}
    if loss == "never came":
        return 503, {"__type": "ServiceUnavailable", "Message": "try again"}
    answer = reply()
    if loss == "cut":
        return None
    if loss == "unavailable":
        return 503, {"__type": "ServiceUnavailable", "Message": "try again"}
    if loss == "slow":
        time.sleep(LATE_S)
    return answer


BONUS_FIELDS = ("WorkerId", "AssignmentId", "BonusAmount", "Reason", "GrantTime")


class MechanicalTurk:
    """Requesters' operations by boto3's protocol, and workers' ``externalSubmit``."""

    def __init__(self) -> None:
        self.hits: dict[str, dict[str, Any]] = {}
        self.tokens: dict[str, str] = {}
        self.assignments: dict[str, dict[str, Any]] = {}
        self.bonuses: list[dict[str, Any]] = []
        self.bonus_tokens: set[str] = set()
        self.calls: list[str] = []
        self.losses: dict[str, Loss] = {}
        """Operations whose next answer is lost."""
        self.page = 2
        self.is_endless = False
        """Whether lists go back to their beginning after the last page."""
        self.others: list[dict[str, Any]] = []
        """HITs of other programs, which have what is required only."""

    def __call__(self, method: str, path: str, headers: dict[str, str], body: bytes) -> Reply:
        if path == "/mturk/externalSubmit":
            return self.external_submit(parse_qs(body.decode()))
        assert "AWS4-HMAC-SHA256" in headers["HTTP_AUTHORIZATION"]
        operation = headers["HTTP_X_AMZ_TARGET"].rpartition(".")[2]
        self.calls.append(operation)
        request = json.loads(body)
        return lossy(
            self.losses, operation, lambda: cast("Reply", getattr(self, operation)(request))
        )

    def let_a_day_pass(self) -> None:
        """Tokens are known for 24 hours."""
        self.tokens.clear()
        self.bonus_tokens.clear()

    def accept(self, worker: str) -> dict[str, str]:
        """A worker accepts a HIT: what the platform adds to the address in the frame."""
        hit = next(
            h
            for h in self.hits.values()
            if h["taken"] < h["MaxAssignments"] and h["Expiration"] > time.time()
        )
        hit["taken"] += 1
        assignment = f"A{len(self.assignments) + 1:029}"
        self.assignments[assignment] = {
            "AssignmentId": assignment,
            "WorkerId": worker,
            "HITId": hit["HITId"],
            "AssignmentStatus": "Accepted",
        }
        return {
            "assignmentId": assignment,
            "hitId": hit["HITId"],
            "workerId": worker,
            "turkSubmitTo": "https://workersandbox.mturk.com",
        }

    def external_submit(self, form: dict[str, list[str]]) -> Reply:
        (assignment,) = form["assignmentId"]
        if len(form) < 2 or self.assignments[assignment]["AssignmentStatus"] != "Accepted":
            return 400, {}
        self.assignments[assignment]["AssignmentStatus"] = "Submitted"
        return 200, {}

    def CreateHIT(self, request: dict[str, Any]) -> Reply:  # noqa: N802
        token = request["UniqueRequestToken"]
        if token in self.tokens:
            return _fault(
                "AWS.MechanicalTurk.HitAlreadyExists", f"HIT {self.tokens[token]} has this token"
            )
        hit_id = f"H{len(self.hits) + 1:029}"
        self.tokens[token] = hit_id
        self.hits[hit_id] = {
            **request,
            "HITId": hit_id,
            "HITGroupId": "GROUP",
            "HITStatus": "Assignable",
            "Expiration": time.time() + request["LifetimeInSeconds"],
            "taken": 0,
        }
        return 200, {"HIT": self._shown(hit_id)}

    def ListHITs(self, request: dict[str, Any]) -> Reply:  # noqa: N802
        return self._page(request, "HITs", [*self.others, *map(self._shown, self.hits)])

    def UpdateExpirationForHIT(self, request: dict[str, Any]) -> Reply:  # noqa: N802
        self.hits[request["HITId"]]["Expiration"] = request["ExpireAt"]
        return 200, {}

    def ListAssignmentsForHIT(self, request: dict[str, Any]) -> Reply:  # noqa: N802
        found = [
            {**a, "SubmitTime": NOW}
            for a in self.assignments.values()
            if a["HITId"] == request["HITId"]
            and a["AssignmentStatus"] in request["AssignmentStatuses"]
        ]
        return self._page(request, "Assignments", found)

    def GetAssignment(self, request: dict[str, Any]) -> Reply:  # noqa: N802
        assignment = self.assignments.get(request["AssignmentId"])
        if assignment is None or assignment["AssignmentStatus"] == "Accepted":
            return _fault("AWS.MechanicalTurk.AssignmentDoesNotExist", "there is none")
        hit = self._shown(assignment["HITId"])
        return 200, {"Assignment": {**assignment, "SubmitTime": NOW}, "HIT": hit}

    def ApproveAssignment(self, request: dict[str, Any]) -> Reply:  # noqa: N802
        return self._move(request, "Approved")

    def RejectAssignment(self, request: dict[str, Any]) -> Reply:  # noqa: N802
        assert request["RequesterFeedback"]
        return self._move(request, "Rejected")

    def SendBonus(self, request: dict[str, Any]) -> Reply:  # noqa: N802
        if request["UniqueRequestToken"] in self.bonus_tokens:
            return _fault("AWS.MechanicalTurk.DuplicateRequest", "this token has been used")
        assignment = self.assignments[request["AssignmentId"]]
        if assignment["WorkerId"] != request["WorkerId"]:
            return _fault("AWS.MechanicalTurk.AssignmentDoesNotExist", "not this worker's")
        self.bonus_tokens.add(request["UniqueRequestToken"])
        self.bonuses.append({**request, "GrantTime": NOW + len(self.bonuses)})
        return 200, {}

    def ListBonusPayments(self, request: dict[str, Any]) -> Reply:  # noqa: N802
        found = [
            {key: b[key] for key in BONUS_FIELDS}
            for b in self.bonuses
            if b["AssignmentId"] == request["AssignmentId"]
        ]
        return self._page(request, "BonusPayments", found)

    def _page(self, request: dict[str, Any], name: str, entries: list[Any]) -> Reply:
        """Small pages, so that clients that read the first only are found out."""
        start = int(request.get("NextToken", "0"))
        page = entries[start : start + self.page]
        reply: dict[str, Any] = {name: page, "NumResults": len(page)}
        if start + self.page < len(entries):
            reply["NextToken"] = str(start + self.page)
        elif self.is_endless:
            reply["NextToken"] = "0"
        return 200, reply

    def status(self, assignment: str) -> str:
        return str(self.assignments[assignment]["AssignmentStatus"])

    def _move(self, request: dict[str, Any], status: str) -> Reply:
        assignment = self.assignments.get(request["AssignmentId"])
        if assignment is None:
            return _fault("AWS.MechanicalTurk.AssignmentDoesNotExist", "there is none")
        if assignment["AssignmentStatus"] != "Submitted":
            return _fault(
                "AWS.MechanicalTurk.InvalidAssignmentState",
                f"This operation can be called with a status of: Submitted, not "
                f"{assignment['AssignmentStatus']}",
            )
        assignment["AssignmentStatus"] = status
        return 200, {}

    def _shown(self, hit_id: str) -> dict[str, Any]:
        hit = self.hits[hit_id]
        names = (
            *("HITId", "HITGroupId", "HITStatus", "MaxAssignments", "RequesterAnnotation"),
            *("Title", "Reward", "Question", "Expiration"),
        )
        available = hit["MaxAssignments"] - hit["taken"]
        return {**{n: hit[n] for n in names}, "NumberOfAssignmentsAvailable": available}


@contextmanager
def serving(platform: Callable[[str, str, dict[str, str], bytes], Reply]) -> Iterator[str]:
    """Serve a platform at an address of this machine."""

    def application(environ: dict[str, Any], start_response: Any) -> list[bytes]:
        length = int(environ.get("CONTENT_LENGTH") or 0)
        body = environ["wsgi.input"].read(length)
        reply = platform(environ["REQUEST_METHOD"], environ["PATH_INFO"], environ, body)
        if reply is None:
            environ["stand_in.socket"].shutdown(socket.SHUT_RDWR)
            return []
        status, value = reply
        content = b"" if value is None else json.dumps(value).encode()
        headers = [("Content-Type", "application/x-amz-json-1.1")]
        start_response(f"{status} -", [*headers, ("Content-Length", str(len(content)))])
        return [content]

    server = make_server("127.0.0.1", 0, application, _Server, _Quiet)
    thread = threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}"
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


class _Server(ThreadingMixIn, WSGIServer):
    daemon_threads = True


class _Quiet(WSGIRequestHandler):
    def get_environ(self) -> Any:
        return {**super().get_environ(), "stand_in.socket": self.connection}

    def log_message(self, *_: Any) -> None:
        pass


def _fault(code: str, message: str) -> Reply:
    return 400, {"__type": "RequestError", "Message": message, "TurkErrorCode": code}
