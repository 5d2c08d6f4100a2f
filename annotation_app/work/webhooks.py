"""Addresses that are notified of a study's finished items, and the messages they get.

Messages and signatures are those of https://www.standardwebhooks.com: its libraries check them.
"""

from __future__ import annotations

import base64
import hashlib
import hmac
from dataclasses import dataclass
from typing import Any

import msgspec
from sqlalchemy import delete, func, select, update
from sqlalchemy.orm import Session

from annotation_app.core.posting import (
    NO_TLS,
    PRIVATE,
    PostProblem,
    addresses_of,
    check_address,
    post,
)
from annotation_app.core.problems import Refusal
from annotation_app.core.random_ids import new_id
from annotation_app.store.audit import note
from annotation_app.store.installation import now
from annotation_app.store.models import Answer, Item, Record, Study
from annotation_app.store.program_models import Webhook, WebhookMessage

EVENT, TEST = "item.finished", "test"


@dataclass(frozen=True, slots=True)
class WebhookState:
    """A webhook, and how it stands with its messages."""

    webhook: str
    study: str
    url: str
    with_answers: bool
    allows_private: bool
    made_by: str
    made_at: float
    waiting: int
    sent: int
    given_up: int
    problem: str
    last_sent_at: float | None


def check_webhook(url: str, *, links_to: str, allows_private: bool = False) -> None:
    """Check whether an address may get messages. Its name is looked up, so it may take seconds.

    It is refused if nothing may be sent there.
    """
    if len(url) > 2000 or len(links_to) > 2000:
        raise Refusal(422, "The address is too long. Use at most 2000 characters.")
    try:
        check_address(links_to, allows_private=True)
        _check_place(url, allows_private=allows_private)
    except PostProblem as problem:
        fix = (
            "Name one that the Internet reaches. Only `ct annotate webhooks add --allow-private` "
            "allows others."
            if str(problem) in (PRIVATE, NO_TLS)
            else "Give one such as https://lab.example.org/hook."
        )
        what = str(problem)
        raise Refusal(422, f"{what[:1].upper()}{what[1:]}. {fix}") from problem


def add_webhook(
    session: Session,
    study: Study,
    url: str,
    *,
    links_to: str,
    with_answers: bool = False,
    allows_private: bool = False,
    actor: str,
) -> Webhook:
    """Notify a checked address of a study's items that are finished from now on."""
    found = Webhook(
        id=new_id(),
        study_id=study.id,
        url=url,
        links_to=links_to.rstrip("/"),
        with_answers=with_answers,
        allows_private=allows_private,
        made_by=actor,
        made_at=now(),
    )
    session.add(found)
    session.flush()
    note(session, actor, "added a webhook", study.name, webhook=found.id)
    return found


def remove_webhook(session: Session, webhook_id: str, *, actor: str) -> None:
    """Tell an address nothing any more, also not what still waits; refused if there is none."""
    found = session.get(Webhook, webhook_id)
    if found is None:
        raise Refusal(404, "There is no such webhook. Look at the list of webhooks.")
    study = session.get_one(Study, found.study_id)
    session.execute(delete(WebhookMessage).where(WebhookMessage.webhook_id == found.id))
    session.delete(found)
    session.flush()
    note(session, actor, "removed a webhook", study.name, webhook=webhook_id)


def webhook_states(session: Session) -> list[WebhookState]:
    """All webhooks, oldest first."""
    hooks = session.execute(
        select(Webhook, Study.name)
        .join(Study, Study.id == Webhook.study_id)
        .order_by(Webhook.made_at, Webhook.id)
    ).all()
    state, ended = WebhookMessage.state, WebhookMessage.ended_at
    numbers = [func.count().filter(state == one) for one in ("waiting", "sent", "given up")]
    last_sent = func.max(ended).filter(state == "sent")
    told = select(WebhookMessage.webhook_id, last_sent, *numbers)
    rows = session.execute(told.group_by(WebhookMessage.webhook_id))
    known: dict[str, tuple[Any, ...]] = {hook: tuple(rest) for hook, *rest in rows}
    found = []
    for hook, study in hooks:
        last, waiting, sent, given_up = known.get(hook.id, (None, 0, 0, 0))
        allowed = (hook.with_answers, hook.allows_private)
        about = (hook.id, study, hook.url, *allowed, hook.made_by, hook.made_at)
        problem = _last_problem(session, hook.id)
        found.append(WebhookState(*about, waiting, sent, given_up, problem, last))
    return found


def last_messages(session: Session, webhook_id: str, most: int) -> list[tuple[WebhookMessage, str]]:
    """The newest messages to a webhook, and the tasks of their items. Old ones are forgotten."""
    found = session.execute(
        select(WebhookMessage, Item.task)
        .join(Item, Item.id == WebhookMessage.item_id)
        .where(WebhookMessage.webhook_id == webhook_id)
        .order_by(WebhookMessage.made_at.desc(), WebhookMessage.id)
        .limit(most)
    )
    return [(message, task) for message, task in found]


def try_again(session: Session, *, now: float, webhook_id: str | None = None) -> int:
    """Have all messages tried at once that wait or were given up; how many these are."""
    failed = update(WebhookMessage).where(WebhookMessage.state.in_(("waiting", "given up")))
    if webhook_id is not None:
        failed = failed.where(WebhookMessage.webhook_id == webhook_id)
    again = failed.values(state="waiting", next_at=now, made_at=now, ended_at=None)
    return len(session.execute(again.returning(WebhookMessage.id)).all())


def send_test(hook: Webhook, study: str, secret_key: bytes) -> str:
    """Send a test message, once and at once; why it didn't arrive, or nothing."""
    at = now()
    content = msgspec.json.encode({"type": TEST, "timestamp": at, "data": {"study": study}})
    headers = signed(signing_key(secret_key, hook.id), new_id(), at, content)
    try:
        post(hook.url, content, headers, allows_private=hook.allows_private)
    except PostProblem as problem:
        return str(problem)
    return ""


def signing_key(secret_key: bytes, webhook_id: str) -> bytes:
    """What messages to a webhook are signed with; nothing keeps it."""
    return hmac.digest(secret_key, f"webhook {webhook_id}".encode(), hashlib.sha256)


def written_secret(secret_key: bytes, webhook_id: str) -> str:
    """The same, in the form that whoever gets the messages is given."""
    return f"whsec_{base64.b64encode(signing_key(secret_key, webhook_id)).decode()}"


def signed(key: bytes, message_id: str, at: float, content: bytes) -> dict[str, str]:
    """The headers of a message."""
    what = b".".join((message_id.encode(), str(int(at)).encode(), content))
    signature = base64.b64encode(hmac.digest(key, what, hashlib.sha256)).decode()
    return {
        "Content-Type": "application/json",
        "User-Agent": "corpus-tools-g3",
        "webhook-id": message_id,
        "webhook-timestamp": str(int(at)),
        "webhook-signature": f"v1,{signature}",
    }


def content_of(session: Session, hook: Webhook, message: WebhookMessage) -> bytes:
    """What a message says. Answers are as they are when it is sent: none was erased since."""
    item = session.get_one(Item, message.item_id)
    study = session.get_one(Study, item.study_id)
    page = f"{hook.links_to}/dashboard/{study.name}"
    link = f"{page}/answers/{message.answer_id}"
    if message.about == "in dispute":
        link = f"{page}/queue/{item.id}"
    data: Record = {
        "study": study.name,
        "item": item.id,
        "task": item.task,
        "state": message.about,
        "link": link,
    }
    if hook.with_answers:
        answers = session.scalars(
            select(Answer)
            .where(Answer.item_id == item.id, Answer.excluded.is_(False))
            .order_by(Answer.id)
        )
        data["command"] = item.command
        data["answers"] = [
            {"answer": one.id, "adopted": one.adopted, "body": one.body} for one in answers
        ]
    told = {"type": EVENT, "timestamp": message.made_at, "data": data}
    return msgspec.json.encode(told)


def _check_place(url: str, *, allows_private: bool) -> None:
    """See where an address leads to now; it is looked at again whenever something is sent."""
    parts = check_address(url, allows_private=allows_private)
    try:
        addresses_of(parts, allows_private=allows_private)
    except PostProblem as problem:
        if str(problem) == PRIVATE:  # a name that isn't known yet may be known later
            raise


def _last_problem(session: Session, webhook_id: str) -> str:
    problem = session.scalar(
        select(WebhookMessage.problem)
        .where(
            WebhookMessage.webhook_id == webhook_id,
            WebhookMessage.state != "sent",
            WebhookMessage.problem != "",
        )
        .order_by(WebhookMessage.made_at.desc())
        .limit(1)
    )
    return problem or ""
