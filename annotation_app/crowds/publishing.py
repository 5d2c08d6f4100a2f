"""Offering a study's work."""

from __future__ import annotations

import secrets
from collections.abc import Iterator
from decimal import Decimal
from urllib.parse import urlencode, urlsplit

from annotation_app.core.languages import gettext, speaking
from annotation_app.crowds.crowd_session import CrowdSession
from annotation_app.crowds.links import INVITATION
from annotation_app.crowds.offering import Offers, offer_again
from annotation_app.crowds.one_at_a_time import one_at_a_time
from annotation_app.crowds.participation import Offer, completion_code, sign_offer
from annotation_app.crowds.platform import Posted, Posting
from annotation_app.people.participants import invitation
from annotation_app.store.models import TaskName
from annotation_app.studies.study_file import StudyConfig, restored
from annotation_app.tasks.task_registry import task_of
from g3.errors import FormatError


def publish_posting(
    session: CrowdSession,
    *,
    url: str,
    task: TaskName | None,
    items: int,
    people: int,
    minutes: int,
    min_approval: int,
    min_approved: int,
    publish_again: tuple[int, ...] = (),
) -> Posted:
    """Offer work at a platform, as far as it isn't offered already.

    Parameters
    ----------
    publish_again
        Entries of the ledger in doubt, of which somebody has seen that they aren't there.

    Raises
    ------
    FormatError
        If the study can't be offered so.
    PlatformError
        If the platform refuses, or nobody knows whether it has offered the work.
    """
    assert session.platform is not None  # noqa: S101 - only commands of platforms offer work
    study = restored(session.study.config)
    offer = _offer(session, study, task, items)
    if study.payment is None:
        raise FormatError(
            "the study doesn't say what is paid", where=study.name, fix="give it a payment"
        )
    with speaking(study.locale):
        description = gettext(task_of(offer.task).words.offer)
    posting = Posting(
        study_id=session.study.id,
        title=study.title,
        description=description,
        task=offer.task,
        items=items,
        people=people,
        reward=(Decimal(str(study.payment.amount)) * items).quantize(Decimal("0.01")),
        minutes=minutes,
        url=_address(session, url, offer, session.provider.load().query),
        code=completion_code(session.config.secret_key, offer),
        min_approval=min_approval,
        min_approved=min_approved,
    )
    with one_at_a_time(session.engine, session.study.id):
        session.ledger.doubt_what_stopped()
        offer_again(session.ledger, publish_again)
        posted = session.platform.post(posting, Offers(session.ledger))
        session.note("published", task=posting.task, people=posted.people, added=posted.added)
    return posted


def publish_links(
    session: CrowdSession, *, url: str, task: TaskName | None, items: int, people: int
) -> Iterator[str]:
    """The open link of a study, or new links for each person who is invited.

    Raises
    ------
    FormatError
        If the study has no such task, or several links are wanted of one that is open.
    """
    study = restored(session.study.config)
    offer = _offer(session, study, task, items)
    if study.access == "open":
        if people > 1:
            raise FormatError(
                "the study is open: all people use the same link",
                where=study.name,
                fix="leave out --people, or give its file `access: invited`",
            )
        yield _address(session, url, offer, "")
        return
    for _ in range(people):
        name = secrets.token_hex(16)
        token = invitation(session.config.secret_key, session.study.id, name)
        yield _address(session, url, offer, urlencode({INVITATION: token}))


def _offer(session: CrowdSession, study: StudyConfig, task: TaskName | None, items: int) -> Offer:
    chosen = task or next(iter(study.tasks))
    if chosen not in study.tasks:
        raise FormatError(
            f"the study has no task {chosen}",
            where=study.name,
            fix=f"use one of {', '.join(study.tasks)}",
        )
    return Offer(session.study.id, chosen, items)


def _address(session: CrowdSession, url: str, offer: Offer, query: str) -> str:
    parts = urlsplit(url)
    if parts.scheme not in ("http", "https") or not parts.netloc:
        raise FormatError(
            "this is no address", where=url, fix="give one such as https://lab.example.org"
        )
    token = sign_offer(session.config.secret_key, offer)
    address = f"{url.rstrip('/')}/crowd/{session.provider.name}/{token}"
    return f"{address}?{query}" if query else address
