"""Amazon Mechanical Turk's requester interface, by boto3.

HITs are found again by their annotation. Calls that offer and pay carry a token, by which the
platform knows for a day that it has carried them out. What was sent and not answered is never
sent again from here: the ledger decides that.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from datetime import datetime, timedelta, timezone
from decimal import Decimal, InvalidOperation
from hashlib import sha256
from typing import Any
from xml.sax.saxutils import escape

import boto3
from botocore.config import Config as BotoConfig
from botocore.exceptions import (
    BotoCoreError,
    ClientError,
    ConnectTimeoutError,
    EndpointConnectionError,
    NoCredentialsError,
    ParamValidationError,
    PartialCredentialsError,
    ProxyConnectionError,
)

from annotation_app.crowds.paging import Page, read_pages
from annotation_app.crowds.platform import (
    Bonus,
    Calls,
    LostReplyError,
    Offered,
    PlatformError,
    Posted,
    Posting,
    Standing,
    Submission,
    label_prefix,
)
from annotation_app.store.models import Record

NAME = "Mechanical Turk"
FIX = "check AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY and the network"
READING_ATTEMPTS = 4
PAGE = 100
REGION = "us-east-1"
SANDBOX = "https://mturk-requester-sandbox.us-east-1.amazonaws.com"
PAGES = {False: "https://worker.mturk.com", True: "https://workersandbox.mturk.com"}
SCHEMA = (
    "http://mechanicalturk.amazonaws.com/AWSMechanicalTurkDataSchemas/2006-07-14/"
    "ExternalQuestion.xsd"
)
MOST_AT_LOWER_FEE = 9
"""Largest number of assignments of a HIT at the platform's lower fee; from ten on it doubles."""
DAY_S = 86_400
OPEN_DAYS, REVIEW_DAYS = 14, 14
PERCENT_APPROVED, NUMBER_APPROVED = "000000000000000000L0", "00000000000000000040"
"""Qualifications that the platform itself keeps."""
ALREADY = "AlreadyExists"
"""Part of the error codes of requests that had been carried out before."""
TOKEN_LASTS_S = 23 * 3600.0
"""Tokens are known for 24 hours; clocks may differ."""
SERVER_ERROR = 500
NOT_SENT = (
    ConnectTimeoutError,
    EndpointConnectionError,
    NoCredentialsError,
    ParamValidationError,
    PartialCredentialsError,
    ProxyConnectionError,
)
"""Errors after which the platform can't have got the request."""
STANDINGS: dict[str, Standing] = {
    "Submitted": "submitted",
    "Approved": "approved",
    "Rejected": "rejected",
}


class MechanicalTurk:
    """A requester's account; see :class:`annotation_app.crowds.platform.Platform`."""

    token_lasts_s = TOKEN_LASTS_S
    lists_all = False

    def __init__(self, reading: Any, writing: Any, *, sandbox: bool) -> None:
        self._reading = reading
        self._writing = writing
        self._sandbox = sandbox
        self.realm = "sandbox" if sandbox else ""

    def post(self, posting: Posting, calls: Calls) -> Posted:
        """Make HITs of up to nine assignments each, as many as are missing.

        HITs whose time ran out before all of their assignments were done are opened again.
        """
        hits = [hit for hit in self._hits() if _label(hit).startswith(f"{posting.label} ")]
        for hit in hits:
            calls.settle(hit["RequesterAnnotation"], hit["HITId"])
            self._open_again(hit, calls)
        before = people = sum(hit["MaxAssignments"] for hit in hits)
        while people < posting.people:
            count = min(MOST_AT_LOWER_FEE, posting.people - people)
            hits += self._make(posting, count, people, calls)
            people += count
        group = next((hit["HITGroupId"] for hit in reversed(hits) if "HITGroupId" in hit), "")
        address = f"{PAGES[self._sandbox]}/mturk/preview?groupId={group}"
        return Posted(tuple(hit["HITId"] for hit in hits), people, people - before, address)

    def offered(self, study_id: str, ids: Collection[str]) -> Sequence[Offered]:
        """Return all HITs that have a label of a study, or one of the ids."""
        prefix = label_prefix(study_id)
        return [
            Offered(hit["HITId"], _label(hit), _money(hit.get("Reward")))
            for hit in self._hits()
            if _label(hit).startswith(prefix) or hit["HITId"] in ids
        ]

    def submissions(self, work: Offered) -> Iterator[Submission]:
        """Return all assignments that workers have sent in; the others aren't listed."""
        asked = {"HITId": work.id, "AssignmentStatuses": [*STANDINGS]}
        for entry in self._list("list_assignments_for_hit", "Assignments", "AssignmentId", **asked):
            standing = STANDINGS.get(entry.get("AssignmentStatus", ""), "working")
            person = entry.get("WorkerId", "")
            yield Submission(entry["AssignmentId"], person, work.id, standing, work.reward)

    def standing(self, submission: Submission) -> Standing:
        """Return the platform's current status of a submitted assignment."""
        reply = _ask(self._reading.get_assignment, AssignmentId=submission.assignment)
        return STANDINGS.get(reply.get("Assignment", {}).get("AssignmentStatus", ""), "working")

    def approve(self, submission: Submission) -> None:
        """Approve an assignment."""
        _change(self._writing.approve_assignment, AssignmentId=submission.assignment)

    def reject(self, submission: Submission, reason: str) -> None:
        """Reject an assignment."""
        _change(
            self._writing.reject_assignment,
            AssignmentId=submission.assignment,
            RequesterFeedback=reason,
        )

    def prepare(self, submission: Submission, bonus: Bonus) -> str:
        """Return the token of a bonus, which is the same each time."""
        return sha256(f"{submission.assignment} {bonus.key}".encode()).hexdigest()

    def pay(self, submission: Submission, bonus: Bonus, reference: str) -> None:
        """Pay a bonus. The platform refuses a token that it knows."""
        _change(
            self._writing.send_bonus,
            WorkerId=submission.person,
            AssignmentId=submission.assignment,
            BonusAmount=str(bonus.amount),
            Reason=bonus.reason,
            UniqueRequestToken=reference,
        )

    def paid(self, submission: Submission) -> Sequence[Decimal]:
        """Return the amounts of all bonuses that were paid for an assignment."""
        where = f"{NAME}, bonuses of {submission.assignment}"
        asked = {"AssignmentId": submission.assignment}
        bonuses = self._list("list_bonus_payments", "BonusPayments", "", **asked)
        amounts = [_money(bonus.get("BonusAmount")) for bonus in bonuses]
        if None in amounts:
            raise PlatformError("a bonus has no amount", where=where)
        return [amount for amount in amounts if amount is not None]

    def close(self) -> None:
        """Close the connections."""
        self._reading.close()
        self._writing.close()

    def _hits(self) -> list[Any]:
        return self._list("list_hits", "HITs", "HITId")

    def _open_again(self, hit: Any, calls: Calls) -> None:
        now, hit_id, left = datetime.now(timezone.utc), hit["HITId"], "NumberOfAssignmentsAvailable"
        key = f"{hit['RequesterAnnotation']} open again {hit_id}"
        calls.settle(key, hit_id if hit["Expiration"] >= now else None)
        if hit["Expiration"] >= now or not hit[left]:
            return

        def do() -> str:
            until = now + timedelta(days=OPEN_DAYS)
            _change(self._writing.update_expiration_for_hit, HITId=hit_id, ExpireAt=until)
            return str(hit_id)

        calls.make(key, f"{hit[left]} assignments again", do)

    def _make(self, posting: Posting, count: int, index: int, calls: Calls) -> list[Any]:
        """Return the HIT that was made; none if the platform already has one."""
        question = (
            f'<ExternalQuestion xmlns="{SCHEMA}"><ExternalURL>{escape(posting.url)}'
            "</ExternalURL><FrameHeight>0</FrameHeight></ExternalQuestion>"
        )
        made: list[Any] = []
        key = f"{posting.label} {index}"

        def do() -> str:
            try:
                reply = _change(
                    self._writing.create_hit,
                    Title=posting.title,
                    Description=posting.description,
                    Question=question,
                    Reward=str(posting.reward),
                    MaxAssignments=count,
                    LifetimeInSeconds=OPEN_DAYS * DAY_S,
                    # Nobody should lose the pay because they were slow.
                    AssignmentDurationInSeconds=max(30, 4 * posting.minutes) * 60,
                    AutoApprovalDelayInSeconds=REVIEW_DAYS * DAY_S,
                    RequesterAnnotation=key,
                    QualificationRequirements=list(_requirements(posting)),
                    UniqueRequestToken=f"{posting.study_id}-{posting.task}-{posting.items}-{index}",
                )
            except PlatformError as error:
                if (
                    isinstance(error, LostReplyError)
                    or ALREADY.casefold() not in error.what.casefold()
                ):
                    raise
                return key
            made.append(reply["HIT"])
            return str(reply["HIT"]["HITId"])

        about = f"{count} assignments at {posting.reward}"
        calls.make(key, about, do, reward=posting.reward, token_lasts_s=TOKEN_LASTS_S)
        return made

    def _list(self, operation: str, field: str, key: str, **arguments: Any) -> list[Record]:
        """Return a list; bonuses have no `key`, and are distinguished by all of their fields."""

        def read(token: str | None) -> Page:
            more = {} if token is None else {"NextToken": token}
            request = getattr(self._reading, operation)
            reply = _ask(request, MaxResults=PAGE, **arguments, **more)
            entries = reply.get(field) or ()
            if not key:
                entries = [
                    {**entry, "": f"{entry if 'GrantTime' in entry else (token, number)}"}
                    for number, entry in enumerate(entries)
                ]
            return Page(entries, reply.get("NextToken"))

        return read_pages(read, key, f"{NAME}, {operation}")


def open_mturk(*, sandbox: bool, endpoint: str | None = None) -> MechanicalTurk:
    """Sign in with boto3's credentials; a PlatformError if the client can't be made."""

    def client(attempts: int) -> Any:
        return boto3.client(
            "mturk",
            region_name=REGION,
            endpoint_url=endpoint or (SANDBOX if sandbox else None),
            config=BotoConfig(retries={"mode": "standard", "total_max_attempts": attempts}),
        )

    reading, writing = (_ask(client, attempts=attempts) for attempts in (READING_ATTEMPTS, 1))
    return MechanicalTurk(reading, writing, sandbox=sandbox)


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
    """Make a request that changes nothing."""
    try:
        return request(**arguments)
    except ClientError as error:
        raise PlatformError(_told(error), where=NAME) from error
    except BotoCoreError as error:
        raise PlatformError(str(error), where=NAME, fix=FIX) from error


def _change(request: Callable[..., Any], **arguments: Any) -> Any:
    """Make a request that changes something, once."""
    try:
        return request(**arguments)
    except ClientError as error:
        status = error.response.get("ResponseMetadata", {}).get("HTTPStatusCode", SERVER_ERROR)
        lost = LostReplyError if status >= SERVER_ERROR else PlatformError
        raise lost(_told(error), where=NAME) from error
    except NOT_SENT as error:
        raise PlatformError(str(error), where=NAME, fix=FIX) from error
    except BotoCoreError as error:
        raise LostReplyError(f"there was no answer: {error}", where=NAME, fix=FIX) from error


def _label(hit: Record) -> str:
    return str(hit.get("RequesterAnnotation") or "")


def _money(value: Any) -> Decimal | None:
    """Return an amount as the platform writes it; None if it isn't one."""
    try:
        amount = Decimal(value)
    except (InvalidOperation, TypeError, ValueError):
        return None
    return amount if amount.is_finite() else None


def _told(error: ClientError) -> str:
    found = error.response.get("Error", {})
    code = error.response.get("TurkErrorCode") or found.get("Code", "error")
    return f"{code}: {found.get('Message', error)}"
