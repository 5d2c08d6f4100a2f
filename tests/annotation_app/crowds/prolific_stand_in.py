"""Prolific on this machine, by its published contract: https://docs.prolific.com/api-reference."""

from __future__ import annotations

import json
from decimal import Decimal
from typing import Any

from tests.annotation_app.crowds.stand_ins import Loss, Reply, lossy


class Prolific:
    """Researchers' operations, and participants who come and go.

    Bonuses are paid asynchronously, when :meth:`let_minutes_pass` is called. Ordering the same
    bulk payment twice pays it twice. Transitions of submissions are idempotent. New studies may
    be missing in lists for a while.
    """

    def __init__(self) -> None:
        self.studies: dict[str, dict[str, Any]] = {}
        self.submissions: dict[str, dict[str, Any]] = {}
        self.bulk: dict[str, dict[str, Any]] = {}
        self.orders: list[tuple[str, Decimal]] = []
        """Submissions and amounts, as often as their payment was ordered."""
        self.test_runs: list[str] = []
        self.calls: list[str] = []
        self.losses: dict[str, Loss] = {}
        """Operations whose next answer is lost."""
        self.unlisted = 0
        """For how many more lists new studies are missing in them."""
        self._hidden: dict[str, int] = {}
        self._landed = 0

    def __call__(self, method: str, path: str, headers: dict[str, str], body: bytes) -> Reply:
        if headers.get("HTTP_AUTHORIZATION") != "Token secret":
            return 401, {"error": {"title": "Unauthorised"}}
        request = json.loads(body) if body else {}
        route = [method, *path.strip("/").split("/")[2:]]
        operation = operation_of(route, request)
        self.calls.append(operation)
        return lossy(self.losses, operation, lambda: self._reply(request, route))

    def begin(self, person: str) -> dict[str, str]:
        (study_id,) = self.studies
        submission = f"sub{len(self.submissions) + 1}"
        self.submissions[submission] = {
            "id": submission,
            "participant_id": person,
            "study_id": study_id,
            "status": "ACTIVE",
            "bonus_payments": None,
        }
        return {"PROLIFIC_PID": person, "STUDY_ID": study_id, "SESSION_ID": submission}

    def let_minutes_pass(self) -> None:
        """What was ordered is paid."""
        for submission, amount in self.orders[self._landed :]:
            paid = self.submissions[submission]["bonus_payments"] or []
            self.submissions[submission]["bonus_payments"] = [*paid, float(amount * 100)]
        self._landed = len(self.orders)

    def _reply(self, request: dict[str, Any], route: list[str]) -> Reply:  # noqa: C901
        match route:
            case ["GET", "studies"]:
                return 200, {"results": list(self._listed())}
            case ["GET", "studies", study_id]:
                return (200, self.studies[study_id]) if study_id in self.studies else _missing()
            case ["POST", "studies"]:
                study_id = f"study{len(self.studies) + 1}"
                self.studies[study_id] = {**request, "id": study_id, "status": "UNPUBLISHED"}
                self._hidden[study_id] = self.unlisted
                return 201, self.studies[study_id]
            case ["PATCH", "studies", study_id]:
                self.studies[study_id].update(request)
                return 200, self.studies[study_id]
            case ["POST", "studies", study_id, "transition"]:
                assert request == {"action": "PUBLISH"}
                if self.studies[study_id]["status"] != "UNPUBLISHED":
                    return 400, {"error": {"detail": "Only drafts can be published"}}
                self.studies[study_id]["status"] = "ACTIVE"
                return 200, self.studies[study_id]
            case ["POST", "studies", study_id, "test-study"]:
                self.test_runs.append(study_id)
                return 200, {"study_id": "t", "study_url": f"https://app.prolific.com/t/{study_id}"}
            case ["GET", "studies", study_id, "submissions"]:
                found = [s for s in self.submissions.values() if s["study_id"] == study_id]
                return 200, {"results": [_basic(submission) for submission in found]}
            case ["GET", "submissions", submission_id]:
                if submission_id not in self.submissions:
                    return _missing()
                found_one = self.submissions[submission_id]
                details = {"participant": found_one["participant_id"]}
                return 200, {**_basic(found_one), **details, **_payments(found_one)}
            case ["POST", "submissions", "bonus-payments"]:
                return self._set_up(request)
            case ["POST", "bulk-bonus-payments", bulk_id, "pay"]:
                if bulk_id not in self.bulk:
                    return _missing()
                self.orders += self.bulk[bulk_id]["payments"]
                return 202, f"Bulk bonus payment with ID {bulk_id} is being processed."
            case ["POST", "submissions", submission_id, "transition"]:
                return self._transition(submission_id, request)
        return _missing()

    def _listed(self) -> list[dict[str, Any]]:
        shown = [s for study_id, s in self.studies.items() if not self._hidden[study_id]]
        self._hidden = {study_id: max(0, left - 1) for study_id, left in self._hidden.items()}
        return shown

    def _set_up(self, request: dict[str, Any]) -> Reply:
        payments = []
        for line in request["csv_bonuses"].splitlines():
            whom, amount = line.split(",")
            # Participants can be named as well as their submissions.
            found = [
                s["id"]
                for s in self.submissions.values()
                if whom in (s["id"], s["participant_id"]) and s["study_id"] == request["study_id"]
            ]
            if not found:
                return 400, {"error": {"detail": f"{whom} has not taken part"}}
            payments.append((found[0], Decimal(amount)))
        bulk_id = f"bulk{len(self.bulk) + 1}"
        self.bulk[bulk_id] = {**request, "payments": payments}
        total = float(sum(amount for _, amount in payments) * 100)
        return 201, {"id": bulk_id, "study": request["study_id"], "amount": total, "vat": 0}

    def _transition(self, submission_id: str, request: dict[str, Any]) -> Reply:
        submission = self.submissions[submission_id]
        after = {"APPROVE": "APPROVED", "REJECT": "REJECTED"}[request["action"]]
        if submission["status"] == after:
            return 200, _basic(submission)
        if submission["status"] != "AWAITING REVIEW":
            return 400, {"error": {"detail": "Only submissions that await review"}}
        if request["action"] == "REJECT":
            assert len(request["message"]) >= 100
            assert request["rejection_category"]
        submission["status"] = after
        return 200, _basic(submission)


def operation_of(route: list[str], request: dict[str, Any]) -> str:
    """What a request does, in a word or two; what only reads is ``look``."""
    match route:
        case ["GET", *_]:
            return "look"
        case ["POST", "studies"]:
            return "make study"
        case ["PATCH", "studies", _]:
            return "add places"
        case ["POST", "submissions", "bonus-payments"]:
            return "set up"
    return str(request.get("action", route[-1])).lower()


def _basic(submission: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in submission.items() if name != "bonus_payments"}


def _payments(submission: dict[str, Any]) -> dict[str, Any]:
    return {"bonus_payments": submission["bonus_payments"]}


def _missing() -> Reply:
    return 404, {"error": {"title": "Not found"}}
