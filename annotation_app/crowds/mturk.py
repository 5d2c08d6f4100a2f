"""Amazon Mechanical Turk's workers: an ExternalQuestion in a frame, with a preview."""

from __future__ import annotations

import re
from collections.abc import Mapping

from annotation_app.core.languages import gettext
from annotation_app.core.problems import Refusal
from annotation_app.crowds.platform import Arrival, Ending, Gateway, Platform
from annotation_app.store.models import Participation

NAME = "mturk"
NOT_AVAILABLE = "ASSIGNMENT_ID_NOT_AVAILABLE"
ID = re.compile(r"[0-9A-Za-z]{1,64}")
SITES = ("https://www.mturk.com", "https://workersandbox.mturk.com")
"""Addresses that an assignment may be sent to; any other is refused."""


def enter(arguments: Mapping[str, str], _study_id: str) -> Arrival:
    """Read ``assignmentId``, ``workerId`` and ``turkSubmitTo``."""
    assignment = arguments.get("assignmentId", "")
    if assignment in ("", NOT_AVAILABLE):
        return Arrival(NAME, None, None, is_preview=True)
    worker = arguments.get("workerId", "")
    site = arguments.get("turkSubmitTo", SITES[0]).rstrip("/")
    if not (ID.fullmatch(worker) and ID.fullmatch(assignment)):
        raise Refusal(400, gettext("Mechanical Turk didn't say who you are. Open the HIT again."))
    if site not in SITES:
        raise Refusal(
            400, gettext("This link is not one of Mechanical Turk's. Open the HIT again.")
        )
    return Arrival(NAME, worker, assignment, submit_to=site)


def leave(participation: Participation, code: str) -> Ending:
    """Return the form that completes the assignment at Mechanical Turk."""
    site = participation.outcome.get("submit_to", SITES[0])
    fields = {"assignmentId": participation.assignment, "code": code}
    return Ending(f"{site}/mturk/externalSubmit", fields)


def connect(*, sandbox: bool, endpoint: str | None) -> Platform:
    """Open the requester's interface."""
    from annotation_app.crowds.mturk_client import open_mturk  # noqa: PLC0415 - boto3 is heavy

    return open_mturk(sandbox=sandbox, endpoint=endpoint)


MTURK = Gateway(enter, leave, connect)
