"""Amazon Mechanical Turk's requester interface, by boto3.

HITs are found again by their annotation, so that nothing about them need be kept here: a
program that died after it had made one takes it up again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from datetime import datetime, timedelta, timezone
from decimal import Decimal
from typing import Any
from xml.sax.saxutils import escape

import boto3
from botocore.config import Config as BotoConfig
from botocore.exceptions import BotoCoreError, ClientError

from annotation_app.crowds.platform import (
    Bonus,
    PlatformError,
    Posted,
    Posting,
    Standing,
    Submission,
    label_prefix,
)

REGION = "us-east-1"
SANDBOX = "https://mturk-requester-sandbox.us-east-1.amazonaws.com"
PAGES = {False: "https://worker.mturk.com", True: "https://workersandbox.mturk.com"}
SCHEMA = (
    "http://mechanicalturk.amazonaws.com/AWSMechanicalTurkDataSchemas/2006-07-14/"
    "ExternalQuestion.xsd"
)
MOST_AT_LOWER_FEE = 9
"""From ten assignments a HIT the platform's fee is twice as high."""
DAY_S = 86_400
OPEN_DAYS, REVIEW_DAYS = 14, 14
PERCENT_APPROVED, NUMBER_APPROVED = "000000000000000000L0", "00000000000000000040"
"""Qualifications that the platform itself keeps."""
ALREADY = "AlreadyExists"
"""In the code of errors about requests that had been done before."""
STANDINGS: dict[str, Standing] = {
    "Submitted": "submitted",
    "Approved": "approved",
    "Rejected": "rejected",
}


class MechanicalTurk:
    """A requester's account; see :class:`annotation_app.crowds.platform.Platform`."""

    def __init__(self, client: Any, *, sandbox: bool) -> None:
        self._client = client
        self._sandbox = sandbox

    def post(self, posting: Posting) -> Posted:
        """Make HITs of up to nine assignments each, as many as are missing.

        HITs whose time ran out before all of their assignments were done are opened again.
        """
        hits = list(self._hits(posting.label))
        for hit in hits:
            self._open_again(hit)
        before = people = sum(hit["MaxAssignments"] for hit in hits)
        ids = [hit["HITId"] for hit in hits]
        groups = [hit.get("HITGroupId", "") for hit in hits]
        while people < posting.people:
            count = min(MOST_AT_LOWER_FEE, posting.people - people)
            made = self._make(posting, count, people)
            ids += [made["HITId"]] if made else []
            groups += [made.get("HITGroupId", "")] if made else []
            people += count
        group = next((group for group in reversed(groups) if group), "")
        address = f"{PAGES[self._sandbox]}/mturk/preview?groupId={group}"
        return Posted(tuple(ids), people, people - before, address)

    def submissions(self, study_id: str) -> Iterator[Submission]:
        """All assignments that workers have sent in; nothing tells of the others."""
        for hit in self._hits(label_prefix(study_id)):
            pages = self._pages(
                "list_assignments_for_hit", HITId=hit["HITId"], AssignmentStatuses=[*STANDINGS]
            )
            for page in pages:
                for found in page["Assignments"]:
                    standing = STANDINGS[found["AssignmentStatus"]]
                    yield Submission(
                        found["AssignmentId"], found["WorkerId"], hit["HITId"], standing
                    )

    def approve(self, submission: Submission) -> None:
        """Approve an assignment."""
        _ask(self._client.approve_assignment, AssignmentId=submission.assignment)

    def reject(self, submission: Submission, reason: str) -> None:
        """Reject an assignment."""
        _ask(
            self._client.reject_assignment,
            AssignmentId=submission.assignment,
            RequesterFeedback=reason,
        )

    def prepare(self, submission: Submission, bonus: Bonus) -> str:
        """The token by which the platform knows a bonus that was paid before."""
        return f"{submission.assignment}-{bonus.key}"[:64]

    def pay(self, submission: Submission, bonus: Bonus, reference: str) -> None:
        """Pay a bonus, unless the platform lists it already."""
        if self._is_paid(submission, bonus):
            return
        try:
            _ask(
                self._client.send_bonus,
                WorkerId=submission.person,
                AssignmentId=submission.assignment,
                BonusAmount=str(bonus.amount),
                Reason=bonus.reason,
                UniqueRequestToken=reference,
            )
        except PlatformError:
            # The token was used: the answer to an earlier request was lost on the way.
            if not self._is_paid(submission, bonus):
                raise

    def close(self) -> None:
        """Close the connections."""
        self._client.close()

    def _is_paid(self, submission: Submission, bonus: Bonus) -> bool:
        paid = [
            (Decimal(payment["BonusAmount"]), payment["Reason"])
            for page in self._pages("list_bonus_payments", AssignmentId=submission.assignment)
            for payment in page["BonusPayments"]
        ]
        return (bonus.amount, bonus.reason) in paid

    def _hits(self, prefix: str) -> Iterator[Any]:
        for page in self._pages("list_hits"):
            for hit in page["HITs"]:
                if f"{hit.get('RequesterAnnotation', '')} ".startswith(f"{prefix.rstrip()} "):
                    yield hit

    def _open_again(self, hit: Any) -> None:
        now = datetime.now(timezone.utc)
        if hit["Expiration"] < now and hit["NumberOfAssignmentsAvailable"]:
            _ask(
                self._client.update_expiration_for_hit,
                HITId=hit["HITId"],
                ExpireAt=now + timedelta(days=OPEN_DAYS),
            )

    def _make(self, posting: Posting, count: int, index: int) -> Any:
        question = (
            f'<ExternalQuestion xmlns="{SCHEMA}"><ExternalURL>{escape(posting.url)}'
            "</ExternalURL><FrameHeight>0</FrameHeight></ExternalQuestion>"
        )
        try:
            reply = _ask(
                self._client.create_hit,
                Title=posting.title,
                Description=posting.description,
                Question=question,
                Reward=str(posting.reward),
                MaxAssignments=count,
                LifetimeInSeconds=OPEN_DAYS * DAY_S,
                # Nobody should lose the pay because they were slow.
                AssignmentDurationInSeconds=max(30, 4 * posting.minutes) * 60,
                AutoApprovalDelayInSeconds=REVIEW_DAYS * DAY_S,
                RequesterAnnotation=posting.label,
                QualificationRequirements=list(_requirements(posting)),
                UniqueRequestToken=f"{posting.study_id}-{posting.task}-{posting.items}-{index}",
            )
        except PlatformError as error:
            if ALREADY.casefold() in error.what.casefold():
                return None
            raise
        return reply["HIT"]

    def _pages(self, operation: str, **arguments: Any) -> Iterator[Any]:
        pages = self._client.get_paginator(operation).paginate(
            **arguments, PaginationConfig={"PageSize": 100}
        )
        yield from _ask(lambda: list(pages))


def open_mturk(*, sandbox: bool, endpoint: str | None = None) -> MechanicalTurk:
    """Sign in with boto3's credentials.

    Raises
    ------
    PlatformError
        If the client can't be made.
    """
    client = _ask(
        lambda: boto3.client(
            "mturk",
            region_name=REGION,
            endpoint_url=endpoint or (SANDBOX if sandbox else None),
            config=BotoConfig(retries={"mode": "standard", "max_attempts": 4}),
        )
    )
    return MechanicalTurk(client, sandbox=sandbox)


def _requirements(posting: Posting) -> Iterator[dict[str, Any]]:
    wanted = {PERCENT_APPROVED: posting.min_approval, NUMBER_APPROVED: posting.min_approved}
    for qualification, least in wanted.items():
        if least:
            yield {
                "QualificationTypeId": qualification,
                "Comparator": "GreaterThanOrEqualTo",
                "IntegerValues": [least],
                "ActionsGuarded": "Accept",
            }


def _ask(request: Callable[..., Any], **arguments: Any) -> Any:
    try:
        return request(**arguments)
    except ClientError as error:
        found = error.response.get("Error", {})
        code = error.response.get("TurkErrorCode") or found.get("Code", "error")
        raise PlatformError(
            f"{code}: {found.get('Message', error)}", where="Mechanical Turk"
        ) from error
    except BotoCoreError as error:
        raise PlatformError(
            str(error),
            where="Mechanical Turk",
            fix="check AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY and the network",
        ) from error
