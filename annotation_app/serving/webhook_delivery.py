"""Sending the messages that wait for webhooks, again and again until they arrive.

Before a message is sent, a transaction keeps when somebody else may try it: a process that is
killed meanwhile loses nothing, and the message is sent again, with the same id.
"""

from __future__ import annotations

import random
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from sqlalchemy import Engine, Select, delete, select, update
from sqlalchemy.exc import SQLAlchemyError

from annotation_app.core.posting import PostProblem, post
from annotation_app.store.database import OnlyReadError, reading, transaction
from annotation_app.store.installation import now as time_now
from annotation_app.store.outages import Outage, Outages, outage_of
from annotation_app.store.program_models import Webhook, WebhookMessage
from annotation_app.work.webhooks import content_of, signed, signing_key

PERIOD_S = 2.0
"""How often a server looks for messages."""
CLAIM_S = 60.0
"""How long nobody else tries a message that somebody sends."""
FIRST_WAIT_S, FACTOR, LONGEST_WAIT_S = 10.0, 4.0, 6 * 3600.0
GIVE_UP_S = 3 * 86_400.0
KEEP_S = 30 * 86_400.0
"""How long messages are kept that are done with."""
BATCH = 20


@dataclass(frozen=True, slots=True)
class Delivered:
    """What became of the messages that were tried."""

    sent: int = 0
    failed: int = 0
    given_up: int = 0

    def __add__(self, other: Delivered) -> Delivered:
        return Delivered(
            self.sent + other.sent, self.failed + other.failed, self.given_up + other.given_up
        )


@dataclass(frozen=True, slots=True)
class _Ready:
    """A message that is this process's for a while."""

    id: str
    url: str
    allows_private: bool
    content: bytes
    key: bytes
    attempts: int
    made_at: float


def deliver_due(engine: Engine, secret_key: bytes, *, now: float) -> Delivered:
    """Send what is due at a time, each message once."""
    done = Delivered()
    with reading(engine) as session:
        if session.scalar(_due(now).limit(1)) is None:
            return done
    while found := _claimed(engine, secret_key, now):
        for message in found:
            done += _sent(engine, message, now)
    with transaction(engine) as session:
        session.execute(
            delete(WebhookMessage).where(
                WebhookMessage.state != "waiting", WebhookMessage.ended_at < now - KEEP_S
            )
        )
    return done


@contextmanager
def delivering(engine: Engine, secret_key: bytes, outages: Outages) -> Iterator[None]:
    """Send messages in the background as they come."""
    end = threading.Event()

    def go_on() -> None:
        while not end.wait(PERIOD_S):
            try:
                deliver_due(engine, secret_key, now=time_now())
            except (SQLAlchemyError, OnlyReadError, OSError) as error:
                outage = outage_of(error) or Outage("webhooks can't be told", type(error).__name__)
                outages.failed(outage)

    thread = threading.Thread(target=go_on, name="webhooks", daemon=True)
    thread.start()
    try:
        yield
    finally:
        end.set()
        thread.join(1.0)


def wait_s(attempts: int) -> float:
    """How long to wait after so many attempts, without what spreads messages."""
    return min(FIRST_WAIT_S * FACTOR ** min(attempts - 1, 20), LONGEST_WAIT_S)


def _due(now: float) -> Select[str]:
    return (
        select(WebhookMessage.id)
        .where(WebhookMessage.state == "waiting", WebhookMessage.next_at <= now)
        .order_by(WebhookMessage.next_at)
    )


def _claimed(engine: Engine, secret_key: bytes, now: float) -> list[_Ready]:
    with transaction(engine) as session:
        ids = session.scalars(_due(now).limit(BATCH).with_for_update(skip_locked=True)).all()
        found = []
        mine = select(WebhookMessage).where(WebhookMessage.id.in_(ids))
        for message in session.scalars(mine.order_by(WebhookMessage.made_at)).all():
            hook = session.get_one(Webhook, message.webhook_id)
            message.attempts += 1
            message.next_at = now + CLAIM_S
            found.append(
                _Ready(
                    message.id,
                    hook.url,
                    hook.allows_private,
                    content_of(session, hook, message),
                    signing_key(secret_key, hook.id),
                    message.attempts,
                    message.made_at,
                )
            )
        return found


def _sent(engine: Engine, message: _Ready, now: float) -> Delivered:
    headers = signed(message.key, message.id, time_now(), message.content)
    problem = ""
    try:
        post(message.url, message.content, headers, allows_private=message.allows_private)
    except PostProblem as found:
        problem = str(found)
    is_over = bool(problem) and now - message.made_at > GIVE_UP_S
    if problem and not is_over:
        again = now + wait_s(message.attempts) * random.uniform(0.8, 1.2)  # noqa: S311 - no secret
        values = {"next_at": again, "problem": problem}
    else:
        state = "given up" if is_over else "sent"
        values = {"state": state, "ended_at": now, "problem": problem}
    with transaction(engine) as session:
        session.execute(
            update(WebhookMessage).where(WebhookMessage.id == message.id).values(**values)
        )
    if not problem:
        return Delivered(sent=1)
    return Delivered(given_up=1) if is_over else Delivered(failed=1)
