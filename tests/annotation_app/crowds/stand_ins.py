"""Crowd platforms on this machine: HTTP servers with the operations that are used, and state."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from socketserver import ThreadingMixIn
from typing import Any
from urllib.parse import parse_qs
from wsgiref.simple_server import WSGIRequestHandler, WSGIServer, make_server

Reply = tuple[int, dict[str, Any] | None]
"""The status, and what is sent as JSON, if anything is."""
NOW = 1_790_000_000.0


class MechanicalTurk:
    """Requesters' operations by boto3's protocol, and workers' ``externalSubmit``."""

    def __init__(self) -> None:
        self.hits: dict[str, dict[str, Any]] = {}
        self.tokens: dict[str, str] = {}
        self.assignments: dict[str, dict[str, Any]] = {}
        self.bonuses: list[dict[str, Any]] = []
        self.bonus_tokens: set[str] = set()
        self.calls: list[str] = []
        self.drop_reply_to: set[str] = set()
        """Operations that are done, but whose answer is lost on the way."""

    def __call__(self, method: str, path: str, headers: dict[str, str], body: bytes) -> Reply:
        if path == "/mturk/externalSubmit":
            return self.external_submit(parse_qs(body.decode()))
        assert "AWS4-HMAC-SHA256" in headers["HTTP_AUTHORIZATION"]
        operation = headers["HTTP_X_AMZ_TARGET"].rpartition(".")[2]
        self.calls.append(operation)
        reply = getattr(self, operation)(json.loads(body))
        if operation in self.drop_reply_to:
            self.drop_reply_to.discard(operation)
            return 503, {"__type": "ServiceUnavailable", "Message": "try again"}
        return reply

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
        # Small pages, so that clients that read the first only are found out.
        ids = list(self.hits)
        start = int(request.get("NextToken", "0"))
        reply: dict[str, Any] = {"HITs": [self._shown(i) for i in ids[start : start + 2]]}
        if start + 2 < len(ids):
            reply["NextToken"] = str(start + 2)
        return 200, reply

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
        return 200, {"Assignments": found, "NumResults": len(found)}

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
        self.bonuses.append(request)
        return 200, {}

    def ListBonusPayments(self, request: dict[str, Any]) -> Reply:  # noqa: N802
        found = [
            {key: b[key] for key in ("WorkerId", "AssignmentId", "BonusAmount", "Reason")}
            for b in self.bonuses
            if b["AssignmentId"] == request["AssignmentId"]
        ]
        return 200, {"BonusPayments": found, "NumResults": len(found)}

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


class Prolific:
    """Researchers' operations, and participants who come and go."""

    def __init__(self) -> None:
        self.studies: dict[str, dict[str, Any]] = {}
        self.submissions: dict[str, dict[str, Any]] = {}
        self.bulk: dict[str, dict[str, Any]] = {}
        self.test_runs: list[str] = []

    def __call__(self, method: str, path: str, headers: dict[str, str], body: bytes) -> Reply:
        if headers.get("HTTP_AUTHORIZATION") != "Token secret":
            return 401, {"error": {"title": "Unauthorised"}}
        request = json.loads(body) if body else {}
        return self._reply(request, [method, *path.strip("/").split("/")[2:]])

    def _reply(self, request: dict[str, Any], route: list[str]) -> Reply:  # noqa: C901
        match route:
            case ["GET", "studies"]:
                return 200, {"results": list(self.studies.values())}
            case ["POST", "studies"]:
                study_id = f"study{len(self.studies) + 1}"
                self.studies[study_id] = {**request, "id": study_id, "status": "UNPUBLISHED"}
                return 201, self.studies[study_id]
            case ["PATCH", "studies", study_id]:
                self.studies[study_id].update(request)
                return 200, self.studies[study_id]
            case ["POST", "studies", study_id, "transition"]:
                assert request == {"action": "PUBLISH"}
                self.studies[study_id]["status"] = "ACTIVE"
                return 200, self.studies[study_id]
            case ["POST", "studies", study_id, "test-study"]:
                self.test_runs.append(study_id)
                return 200, {"study_id": "t", "study_url": f"https://app.prolific.com/t/{study_id}"}
            case ["GET", "studies", study_id, "submissions"]:
                found = [s for s in self.submissions.values() if s["study_id"] == study_id]
                return 200, {"results": found}
            case ["POST", "submissions", "bonus-payments"]:
                bulk_id = f"bulk{len(self.bulk) + 1}"
                self.bulk[bulk_id] = {**request, "id": bulk_id, "paid": 0}
                return 201, {"id": bulk_id}
            case ["POST", "bulk-bonus-payments", bulk_id, "pay"]:
                self.bulk[bulk_id]["paid"] += 1
                return 202, {}
            case ["POST", "submissions", submission_id, "transition"]:
                return self._transition(submission_id, request)
            case ["POST", "researchers", "participants"]:
                return 201, {"participant_id": "tester1"}
        return 404, {"error": route}

    def begin(self, person: str) -> dict[str, str]:
        (study_id,) = self.studies
        submission = f"sub{len(self.submissions) + 1}"
        self.submissions[submission] = {
            "id": submission,
            "participant_id": person,
            "study_id": study_id,
            "status": "ACTIVE",
        }
        return {"PROLIFIC_PID": person, "STUDY_ID": study_id, "SESSION_ID": submission}

    def _transition(self, submission_id: str, request: dict[str, Any]) -> Reply:
        submission = self.submissions[submission_id]
        if submission["status"] != "AWAITING REVIEW":
            return 400, {"error": {"detail": "Only submissions that await review"}}
        if request["action"] == "REJECT":
            assert len(request["message"]) >= 100
            assert request["rejection_category"]
        submission["status"] = {"APPROVE": "APPROVED", "REJECT": "REJECTED"}[request["action"]]
        return 200, submission


@contextmanager
def serving(platform: Callable[[str, str, dict[str, str], bytes], Reply]) -> Iterator[str]:
    """Serve a platform at an address of this machine."""

    def application(environ: dict[str, Any], start_response: Any) -> list[bytes]:
        length = int(environ.get("CONTENT_LENGTH") or 0)
        body = environ["wsgi.input"].read(length)
        status, value = platform(environ["REQUEST_METHOD"], environ["PATH_INFO"], environ, body)
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
    def log_message(self, *_: Any) -> None:
        pass


def _fault(code: str, message: str) -> Reply:
    return 400, {"__type": "RequestError", "Message": message, "TurkErrorCode": code}
