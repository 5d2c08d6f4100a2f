"""Prolific's researcher interface (version 1), by httpx.

A study is found again by its internal name, and by the id that the ledger has of it: Prolific's
lists may show a new study late. What was sent and not answered is never sent again from here.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Sequence
from decimal import Decimal
from math import isfinite
from typing import Any, TypeAlias

import httpx

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
from g3.errors import FormatError

NAME = "Prolific"
ADDRESS = "https://api.prolific.com"
TOKEN, PROJECT = "PROLIFIC_TOKEN", "PROLIFIC_PROJECT"
TIMEOUT_S = 30.0
PAGE = 100
"""Studies of a project on one page."""
SHORTEST_REASON = 100
CENTS, CENT = 100, Decimal("0.01")
UNPUBLISHED = "UNPUBLISHED"
LABEL, PAID = "internal_name", "bonus_payments"
PLACES, PUBLISHED = " places ", " published"
"""Suffixes of the ledger's keys of changes of a study, after its label."""
MISSING, SLOW, SERVER_ERROR = 404, 408, 500
NOT_SENT = (
    httpx.ConnectError,
    httpx.ConnectTimeout,
    httpx.PoolTimeout,
    httpx.ProxyError,
    httpx.UnsupportedProtocol,
)
"""Errors after which Prolific can't have got the request."""
STANDINGS: dict[str, Standing] = {
    "RESERVED": "working",
    "ACTIVE": "working",
    "AWAITING REVIEW": "submitted",
    "APPROVED": "approved",
    "PARTIALLY APPROVED": "approved",
    "SCREENED OUT": "approved",
    "REJECTED": "rejected",
    "RETURNED": "returned",
    "TIMED OUT": "returned",
}
Change: TypeAlias = tuple[str, str, dict[str, Any]]
"""A method, the end of a study's path, and what is sent."""


class Prolific:
    """A researcher's account; see :class:`annotation_app.crowds.platform.Platform`."""

    realm = ""
    token_lasts_s = 0.0
    """Paying again by the same reference pays again, by Prolific's own word."""
    lists_all = True

    def __init__(self, client: httpx.Client, *, project: str, sandbox: bool) -> None:
        self._client = client
        self._project = project
        self._sandbox = sandbox

    def post(self, posting: Posting, calls: Calls) -> Posted:
        """Make a study and publish it, or add places to an existing study.

        In the sandbox it stays a draft, of which a test run is made.
        """
        label, places, added = posting.label, posting.people, posting.people
        about = f"{places} places at {posting.reward}"
        study = self._known_study(label, calls)
        if study is None:
            study_id, status = self._make(posting, about, calls), UNPUBLISHED
        else:
            study_id, status = study["id"], _text(study, "status")
            places = study.get("total_available_places")
            if not isinstance(places, int):
                raise PlatformError(
                    "it doesn't say how many places the study has", where=f"{NAME}, {study_id}"
                )
            self._settle(calls, label, study)
            added = max(0, posting.people - places)
            if added:
                places += added
                more: Change = ("PATCH", "", {"total_available_places": places})
                self._offer(calls, f"{label}{PLACES}{places}", about, study_id, more)
        address = f"https://app.prolific.com/researcher/studies/{study_id}"
        if self._sandbox:
            change: Change = ("POST", "test-study", {})
            run = self._offer(calls, f"{label} test run", "a test run", study_id, change)
            address = run.get("study_url", address)
        elif status == UNPUBLISHED:
            change = ("POST", "transition/", {"action": "PUBLISH"})
            self._offer(calls, f"{label}{PUBLISHED}", about, study_id, change)
        return Posted((study_id,), places, added, address)

    def offered(self, study_id: str, ids: Collection[str]) -> Sequence[Offered]:
        """Return all studies that have a label of a study here, or one of the ids.

        Studies that the list doesn't show are looked up by their ids.
        """
        prefix = label_prefix(study_id)
        listed = self._studies()
        studies = [s for s in listed if _text(s, LABEL).startswith(prefix) or s["id"] in ids]
        for missing in sorted(set(ids) - {study["id"] for study in studies}):
            study = self._study(missing)
            studies += [] if study is None else [study]
        return [Offered(s["id"], _text(s, LABEL), _reward(s)) for s in studies]

    def submissions(self, work: Offered) -> Iterator[Submission]:
        """Return all submissions."""
        for entry in self._list(f"studies/{work.id}/submissions/"):
            person = _text(entry, "participant_id")
            yield Submission(entry["id"], person, work.id, _standing(entry), work.reward)

    def standing(self, submission: Submission) -> Standing:
        """Return Prolific's current status of a submission."""
        return _standing(self._submission(submission))

    def approve(self, submission: Submission) -> None:
        """Approve a submission."""
        self._transition(submission, {"action": "APPROVE"})

    def reject(self, submission: Submission, reason: str) -> None:
        """Reject a submission. Prolific wants a hundred characters to say why."""
        if len(reason) < SHORTEST_REASON:
            raise PlatformError(
                f"Prolific wants at least {SHORTEST_REASON} characters to say why",
                where=submission.assignment,
                fix="write to the participant what was missing",
            )
        self._transition(
            submission,
            {"action": "REJECT", "message": reason, "rejection_category": "LOW_EFFORT"},
        )

    def prepare(self, submission: Submission, bonus: Bonus) -> str:
        """Set a bonus up. Nothing is charged until it is paid."""
        line = f"{submission.assignment},{bonus.amount:.2f}"
        body = {"study_id": submission.group, "csv_bonuses": line}
        return str(self._ask("POST", "submissions/bonus-payments/", body)["id"])

    def pay(self, _submission: Submission, _bonus: Bonus, reference: str) -> None:
        """Order the payment of a prepared bonus. A second order pays it twice.

        Prolific pays in the minutes after it has answered.
        """
        self._ask("POST", f"bulk-bonus-payments/{reference}/pay/", {})

    def paid(self, submission: Submission) -> Sequence[Decimal]:
        """Return the amounts of all bonuses that have arrived; ordered ones may be missing."""
        found = self._submission(submission)
        try:
            amounts = [_cents(cents) for cents in found.get(PAID) or ()]
        except TypeError:
            amounts = [None]
        if None in amounts:
            where = f"{NAME}, {submission.assignment}"
            raise PlatformError(f"its {PAID} can't be read: {found.get(PAID)!r:.200}", where=where)
        return [amount for amount in amounts if amount is not None]

    def close(self) -> None:
        """Close the connections."""
        self._client.close()

    def _transition(self, submission: Submission, body: dict[str, Any]) -> None:
        self._ask("POST", f"submissions/{submission.assignment}/transition/", body)

    def _known_study(self, label: str, calls: Calls) -> Any:
        made = calls.reference(label)
        named = [study for study in self._studies() if _text(study, LABEL) == label]
        for study in named:
            if made in (None, study["id"]):
                return self._study(study["id"]) or study
        return None if made is None else self._study(made)

    def _study(self, study_id: str) -> Any:
        """Return a study; None if there is none, or it was deleted."""
        reply = self._send("GET", f"studies/{study_id}/")
        return None if reply.status_code == MISSING else _content(reply)

    def _submission(self, submission: Submission) -> Record:
        found = self._ask("GET", f"submissions/{submission.assignment}/")
        if not isinstance(found, dict):
            raise PlatformError(
                "the answer can't be read", where=f"{NAME}, {submission.assignment}"
            )
        return found

    def _make(self, posting: Posting, about: str, calls: Calls) -> str:
        body = _study(posting, self._project)
        return calls.make(
            posting.label,
            about,
            lambda: str(self._ask("POST", "studies/", body)["id"]),
            reward=posting.reward,
        )

    def _settle(self, calls: Calls, label: str, study: dict[str, Any]) -> None:
        """Record which of the calls in doubt were carried out."""
        for key in calls.in_doubt():
            is_made = key == label
            if key.startswith(f"{label}{PLACES}"):
                is_made = int(key.rpartition(" ")[2]) <= study["total_available_places"]
            elif key == f"{label}{PUBLISHED}":
                is_made = study["status"] != UNPUBLISHED
            elif not is_made:
                continue
            calls.settle(key, study["id"] if is_made else None)

    def _offer(
        self,
        calls: Calls,
        key: str,
        about: str,
        study_id: str,
        change: Change,
    ) -> Any:
        """Change a study in a way that does nothing more when it is done twice."""
        method, path, body = change
        replies = []

        def do() -> str:
            replies.append(self._ask(method, f"studies/{study_id}/{path}", body))
            return study_id

        calls.settle(key, None)
        calls.make(key, about, do)
        return replies[0]

    def _studies(self) -> list[Record]:
        if self._project:
            return self._list(f"projects/{self._project}/studies/", numbered=True)
        return self._list("studies/")

    def _list(self, path: str, *, numbered: bool = False) -> list[Record]:
        """Return a list of Prolific's: whole, or in pages that name the next one.

        `numbered` are those of which the reference says that pages have numbers.
        """

        def read(place: str | int | None) -> Page:
            # A text is the query of a next page, a number that of a page.
            query = place if isinstance(place, str) else ""
            if numbered and not query:
                query = f"?page={place or 1}&page_size={PAGE}"
            reply = self._send("GET", f"{path}{query}")
            if isinstance(place, int) and reply.status_code == MISSING:
                return Page(())
            content = _content(reply)
            entries = content.get("results") if isinstance(content, dict) else None
            if not isinstance(entries, list):
                raise PlatformError("the answer has no results", where=f"{NAME}, {path}")
            following: str | int | None = _next(content, reply.request.url)
            if following is None and numbered and entries and not isinstance(place, str):
                following = (place or 1) + 1
            return Page(entries, following, _count(content))

        return read_pages(read, "id", f"{NAME}, {path}")

    def _ask(
        self, method: str, path: str, body: dict[str, Any] | None = None, **options: Any
    ) -> Any:
        return _content(self._send(method, path, body, **options))

    def _send(
        self, method: str, path: str, body: dict[str, Any] | None = None, **options: Any
    ) -> httpx.Response:
        try:
            return self._client.request(method, f"/api/v1/{path}", json=body, **options)
        except NOT_SENT as error:
            raise PlatformError(str(error), where=NAME, fix="check the network") from error
        except httpx.HTTPError as error:
            what = f"there was no answer: {str(error) or type(error).__name__}"
            raise _lost(method)(what, where=NAME, fix="check the network") from error


def _content(reply: httpx.Response) -> Any:
    """Return the content of a reply, if the request was carried out."""
    status, what = reply.status_code, f"{reply.status_code}: {reply.text[:500]}"
    lost = _lost(reply.request.method)
    if status == SLOW or status >= SERVER_ERROR:
        raise lost(what, where=NAME)
    if not reply.is_success:
        fix = f"check {TOKEN}" if status in (401, 403) else ""
        raise PlatformError(what, where=NAME, fix=fix)
    try:
        return reply.json() if reply.content else {}
    except ValueError:
        raise lost(f"the answer can't be read: {what}", where=NAME) from None


def _next(content: Record, here: httpx.URL) -> str | None:
    """Return the query of the next page's address, if any; an error if it leads elsewhere.

    The token goes to no other address: a page's host and path are those of its list.
    """
    links = content.get("_links")
    link = links.get("next") if isinstance(links, dict) else None
    href = link.get("href") if isinstance(link, dict) else link
    if not href:
        return None
    try:
        address = here.join(href)
    except (TypeError, httpx.InvalidURL):
        address = None
    same = (here.host, here.port, here.path.rstrip("/"))
    if address is None or same != (address.host, address.port, address.path.rstrip("/")):
        raise PlatformError(
            f"the next page of a list is said to be elsewhere: {href!r:.200}",
            where=f"{NAME}, {here.path}",
            fix="nothing was done and the token was not sent there; write to Prolific's support",
        )
    return f"?{address.query.decode()}"


def _count(content: Record) -> int | None:
    meta = content.get("meta")
    count = meta.get("count") if isinstance(meta, dict) else None
    return count if type(count) is int else None


def _text(record: Record, name: str) -> str:
    """Return a field's text; empty where other people's records have none."""
    value = record.get(name)
    return value if isinstance(value, str) else ""


def _standing(record: Record) -> Standing:
    status = _text(record, "status").upper().replace("_", " ").replace("-", " ")
    return STANDINGS.get(status, "working")


def _lost(method: str) -> type[PlatformError]:
    """Return the error for a missing reply: reading can't have done anything."""
    return PlatformError if method == "GET" else LostReplyError


def open_prolific(*, sandbox: bool, endpoint: str | None = None) -> Prolific:
    """Sign in with the token in ``PROLIFIC_TOKEN``; an error if there is none."""
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


def _reward(study: Record) -> Decimal | None:
    return _cents(study.get("reward"))


def _cents(value: Any) -> Decimal | None:
    """Return an amount that is given in cents; None if it isn't one."""
    if not isinstance(value, int | float) or isinstance(value, bool) or not isfinite(value):
        return None
    return (Decimal(str(value)) / CENTS).quantize(CENT)


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
