"""Prolific's researcher interface (version 1), by httpx.

A study is found again by its internal name, so that nothing about it need be kept here.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any

import httpx

from annotation_app.crowds.platform import (
    Bonus,
    PlatformError,
    Posted,
    Posting,
    Standing,
    Submission,
    label_prefix,
)
from g3.errors import FormatError

ADDRESS = "https://api.prolific.com"
TOKEN, PROJECT = "PROLIFIC_TOKEN", "PROLIFIC_PROJECT"
TIMEOUT_S = 30.0
PAGE = 100
SHORTEST_REASON = 100
CENTS = 100
STANDINGS: dict[str, Standing] = {
    "RESERVED": "working",
    "ACTIVE": "working",
    "AWAITING REVIEW": "submitted",
    "APPROVED": "approved",
    "PARTIALLY APPROVED": "approved",
    "SCREENED OUT": "approved",
    "REJECTED": "rejected",
    "RETURNED": "returned",
    "TIMED-OUT": "returned",
}


class Prolific:
    """A researcher's account; see :class:`annotation_app.crowds.platform.Platform`."""

    def __init__(self, client: httpx.Client, *, project: str, sandbox: bool) -> None:
        self._client = client
        self._project = project
        self._sandbox = sandbox

    def post(self, posting: Posting) -> Posted:
        """Make a study and publish it, or give the one that there is more places.

        In the sandbox it stays a draft, of which a test run is made.
        """
        known = [s for s in self._studies() if s["internal_name"] == posting.label]
        if known:
            study, added = known[0], 0
            places = study["total_available_places"]
            if posting.people > places:
                places, added = posting.people, posting.people - places
                self._ask("PATCH", f"studies/{study['id']}/", {"total_available_places": places})
        else:
            study = self._ask("POST", "studies/", _study(posting, self._project))
            places = added = posting.people
        address = f"https://app.prolific.com/researcher/studies/{study['id']}"
        if self._sandbox:
            run = self._ask("POST", f"studies/{study['id']}/test-study", {})
            address = run.get("study_url", address)
        elif study["status"] == "UNPUBLISHED":
            self._ask("POST", f"studies/{study['id']}/transition/", {"action": "PUBLISH"})
        return Posted((study["id"],), places, added, address)

    def submissions(self, study_id: str) -> Iterator[Submission]:
        """All submissions."""
        for study in self._studies():
            if not study["internal_name"].startswith(label_prefix(study_id)):
                continue
            for found in self._results(f"studies/{study['id']}/submissions/"):
                standing = STANDINGS.get(found["status"], "working")
                yield Submission(found["id"], found["participant_id"], study["id"], standing)

    def approve(self, submission: Submission) -> None:
        """Approve a submission."""
        self._transition(submission, {"action": "APPROVE"})

    def reject(self, submission: Submission, reason: str) -> None:
        """Reject a submission. Prolific wants a hundred characters to say why."""
        if len(reason) < SHORTEST_REASON:
            raise PlatformError(
                f"Prolific wants at least {SHORTEST_REASON} characters to say why",
                where=submission.assignment,
                fix="tell the participant what was missing",
            )
        self._transition(
            submission,
            {"action": "REJECT", "message": reason, "rejection_category": "LOW_EFFORT"},
        )

    def prepare(self, submission: Submission, bonus: Bonus) -> str:
        """Set a bonus up. It costs nothing until it is paid."""
        line = f"{submission.person},{bonus.amount:.2f}"
        reply = self._ask(
            "POST",
            "submissions/bonus-payments/",
            {"study_id": submission.group, "csv_bonuses": line},
        )
        return str(reply["id"])

    def pay(self, _submission: Submission, _bonus: Bonus, reference: str) -> None:
        """Pay a bonus that was set up. Prolific pays the same one once only."""
        self._ask("POST", f"bulk-bonus-payments/{reference}/pay/", {})

    def close(self) -> None:
        """Close the connections."""
        self._client.close()

    def add_test_participant(self, email: str) -> str:
        """Make a participant who can take part in test runs only; their id."""
        return str(
            self._ask("POST", "researchers/participants/", {"email": email})["participant_id"]
        )

    def _transition(self, submission: Submission, body: dict[str, Any]) -> None:
        self._ask("POST", f"submissions/{submission.assignment}/transition/", body)

    def _studies(self) -> Iterator[dict[str, Any]]:
        path = f"projects/{self._project}/studies/" if self._project else "studies/"
        return self._results(path)

    def _results(self, path: str) -> Iterator[dict[str, Any]]:
        page = 1
        while True:
            found = self._ask("GET", path, params={"page": page, "page_size": PAGE})["results"]
            yield from found
            if len(found) < PAGE:
                return
            page += 1

    def _ask(
        self, method: str, path: str, body: dict[str, Any] | None = None, **options: Any
    ) -> Any:
        try:
            reply = self._client.request(method, f"/api/v1/{path}", json=body, **options)
        except httpx.HTTPError as error:
            raise PlatformError(str(error), where="Prolific", fix="check the network") from error
        if reply.is_error:
            fix = f"check {TOKEN}" if reply.status_code in (401, 403) else ""
            what = f"{reply.status_code}: {reply.text[:500]}"
            raise PlatformError(what, where="Prolific", fix=fix)
        return reply.json() if reply.content else {}


def open_prolific(*, sandbox: bool, endpoint: str | None = None) -> Prolific:
    """Sign in with the token in ``PROLIFIC_TOKEN``.

    Raises
    ------
    FormatError
        If there is none.
    """
    token = os.environ.get(TOKEN)
    if not token:
        raise FormatError(
            "there is no token for Prolific", fix=f"make one at Prolific and set {TOKEN}"
        )
    client = httpx.Client(
        base_url=endpoint or ADDRESS,
        headers={"Authorization": f"Token {token}"},
        timeout=TIMEOUT_S,
    )
    return Prolific(client, project=os.environ.get(PROJECT, ""), sandbox=sandbox)


def _filters(posting: Posting) -> Iterator[dict[str, Any]]:
    if posting.min_approval:
        approval = {"lower": posting.min_approval, "upper": 100}
        yield {"filter_id": "approval_rate", "selected_range": approval}
    if posting.min_approved:
        yield {"filter_id": "approval_numbers", "selected_range": {"lower": posting.min_approved}}


def _study(posting: Posting, project: str) -> dict[str, Any]:
    study: dict[str, Any] = {
        "name": posting.title,
        "internal_name": posting.label,
        "description": posting.description,
        "external_study_url": posting.url,
        "prolific_id_option": "url_parameters",
        "completion_codes": [
            {
                "code": posting.code,
                "code_type": "COMPLETED",
                "actions": [{"action": "MANUALLY_REVIEW"}],
            }
        ],
        "total_available_places": posting.people,
        "estimated_completion_time": posting.minutes,
        "reward": int(posting.reward * CENTS),
        "device_compatibility": ["desktop", "tablet", "mobile"],
        "filters": list(_filters(posting)),
    }
    return {**study, "project": project} if project else study
