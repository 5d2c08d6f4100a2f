"""Prolific on this machine, by its published contract: https://docs.prolific.com/api-reference.

Lists and records have the fields of the reference. What it leaves open is a switch of
:class:`Freedoms`.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from decimal import Decimal
from typing import Any
from urllib.parse import parse_qs

from tests.annotation_app.crowds.stand_ins import Loss, Reply, lossy


@dataclass
class Freedoms:
    """What the reference leaves open, and what goes wrong at times."""

    page: int | None = None
    """How many entries a page of a list has; None for lists in one piece."""
    counted: bool = True
    """Whether pages say how many entries there are."""
    miscounted: int = 0
    """How many entries there are more by the count than in the list."""
    next_page: str = "{address}?page={number}"
    """Where the next page is said to be."""
    is_endless: bool = False
    """Whether the last page has a next one too, which is the same."""
    others: list[Any] = field(default_factory=list)
    """What is among the studies of other people."""
    fails_late: int = 0
    """How many of the next orders are accepted and never paid."""


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
        self.freedoms = Freedoms()
        self.failed: list[tuple[str, Decimal]] = []
        """Orders that were accepted and weren't carried out."""
        self.project_page: int | None = None
        """How many studies of a project are on a numbered page, which names no next one."""
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
        where = f"{headers.get('address', 'http://' + headers.get('HTTP_HOST', ''))}{path}"
        query = parse_qs(headers.get("QUERY_STRING", ""))
        if route[1:2] == ["projects"]:
            return lossy(self.losses, operation, lambda: self._of_project(query))
        return lossy(
            self.losses,
            operation,
            lambda: self._in_pages(self._reply(request, route), where, query),
        )

    def begin(self, person: str, study_id: str = "") -> dict[str, str]:
        study_id = study_id or next(iter(self.studies))
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
        """What was ordered is paid, unless it fails."""
        for submission, amount in self.orders[self._landed :]:
            if self.freedoms.fails_late:
                self.freedoms.fails_late -= 1
                self.failed.append((submission, amount))
                continue
            paid = self.submissions[submission]["bonus_payments"] or []
            self.submissions[submission]["bonus_payments"] = [*paid, float(amount * 100)]
        self._landed = len(self.orders)

    def has_arrived(self) -> bool:
        """Whether nothing is left of what was ordered and isn't paid yet."""
        return self._landed == len(self.orders)

    def _of_project(self, query: dict[str, list[str]]) -> Reply:
        """Studies on numbered pages, by the reference of this one list."""
        found = [*self.freedoms.others, *self._listed()]
        size = min(int(query.get("page_size", ["20"])[0]), self.project_page or len(found))
        start = (int(query.get("page", ["1"])[0]) - 1) * size
        return (200, {"results": found[start : start + size]}) if start < len(found) else _missing()

    def _in_pages(self, reply: Reply, address: str, query: dict[str, list[str]]) -> Reply:
        """A reply, or a page of it, with the links and the count of the reference."""
        free = self.freedoms
        if reply is None or not isinstance(reply[1], dict) or "results" not in reply[1]:
            return reply
        if free.page is None:
            return reply
        results = reply[1]["results"]
        last = max(1, -(-len(results) // free.page))
        number = min(int(query.get("page", ["1"])[0]), last)
        link = None
        if number < last or free.is_endless:
            link = free.next_page.format(address=address, number=number + 1)
        links = {"next": {"href": link, "title": "Next"}, "previous": {"href": None}}
        page = results[(number - 1) * free.page : number * free.page]
        meta = {"meta": {"count": len(results) + free.miscounted}} if free.counted else {}
        return reply[0], {"results": page, "_links": links, **meta}

    def _reply(self, request: dict[str, Any], route: list[str]) -> Reply:  # noqa: C901
        match route:
            case ["GET", "studies"]:
                return 200, {"results": [*self.freedoms.others, *self._listed()]}
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
                return 200, {"results": [_short(submission) for submission in found]}
            case ["GET", "submissions", submission_id]:
                if submission_id not in self.submissions:
                    return _missing()
                found_one = self.submissions[submission_id]
                return 200, {**_basic(found_one), **_payments(found_one)}
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


STARTED = {"started_at": "2026-11-22T17:40:12Z", "completed_at": None, "return_requested": None}


def _short(submission: dict[str, Any]) -> dict[str, Any]:
    """A submission as lists have it."""
    known = {name: submission[name] for name in ("id", "participant_id", "status")}
    return {**known, **STARTED, "has_siblings": False, "study_code": None}


def _basic(submission: dict[str, Any]) -> dict[str, Any]:
    known = {name: submission[name] for name in ("id", "study_id", "status")}
    participant = {"participant": submission["participant_id"], "parent_study_id": None}
    return {**known, **participant, **STARTED, "entered_code": None}


def _payments(submission: dict[str, Any]) -> dict[str, Any]:
    return {"bonus_payments": submission["bonus_payments"]}


def _missing() -> Reply:
    return 404, {"error": {"title": "Not found"}}
