"""Limits on the frequency of actions, counted by person, else by address."""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Callable
from typing import ParamSpec, TypeVar

import flask
from limits import RateLimitItem, parse_many
from limits.errors import StorageError
from limits.storage import storage_from_string
from limits.strategies import MovingWindowRateLimiter
from werkzeug.exceptions import TooManyRequests

from annotation_app.core import counting  # noqa: F401 - makes process:// known
from annotation_app.people.api_tokens import digest_of
from annotation_app.people.browser_sessions import current_id
from annotation_app.store.installation import installation
from annotation_app.store.outages import Outage

P = ParamSpec("P")
R = TypeVar("R")

submissions = "240/minute"
reads = "600/minute"
"""Limit on reads by programs and the dashboard's own scripts."""
arrivals = "120/minute"
"""New people who come by an open link, by address: a class may sit behind one."""
tries = "10/minute"
sign_ins = "60/minute;600/hour"
"""Passwords sent, right or wrong: to look at one takes a processor a twentieth of a second.

After wrong ones people wait longer (:mod:`annotation_app.people.failed_sign_ins`)."""


def limiter(storage: str) -> MovingWindowRateLimiter:
    """Return the counter of requests, kept at a URL in the form of the package ``limits``."""
    return MovingWindowRateLimiter(storage_from_string(storage, wrap_exceptions=True))


def limited(often: str, *, by_address: bool = False) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Refuse a person's more frequent requests, with the time to wait.

    `by_address` counts by address also for people who are known. Cookies of new people are to be
    had for nothing.
    """

    def decorate(view: Callable[P, R]) -> Callable[P, R]:
        @functools.wraps(view)
        def counted(*args: P.args, **kwargs: P.kwargs) -> R:
            if installation().limiter is not None:
                whose = str(flask.request.remote_addr) if by_address else _whose()
                count_now(often, view.__name__, whose)
            return view(*args, **kwargs)

        return counted

    return decorate


def count_now(often: str, what: str, whose: str) -> None:
    """Count something that was done, and refuse it if it was done too often."""
    counter = installation().limiter
    if counter is not None:
        for limit in _limits(often):
            _count(counter, limit, (what, whose))


_limits = functools.cache(parse_many)


def bearer() -> str | None:
    """Return the token that a program has sent; None if the request is a person's."""
    sent = flask.request.headers.get("Authorization", "")
    scheme, _, token = sent.partition(" ")
    return token.strip() if scheme.lower() == "bearer" else None


def _count(counter: MovingWindowRateLimiter, limit: RateLimitItem, what: tuple[str, str]) -> None:
    try:
        if counter.hit(limit, *what):
            return
        again_s = counter.get_window_stats(limit, *what).reset_time - time.time()
    except StorageError as error:  # where the counting fails, people's work goes on
        reason = type(error.storage_error).__name__
        installation().outages.failed(Outage("requests can't be counted", reason))
        return
    raise TooManyRequests(retry_after=max(1, math.ceil(again_s)))


def _whose() -> str:
    token = bearer()
    if token is not None:
        return f"token {digest_of(token)}"
    person_id = current_id()
    return str(flask.request.remote_addr) if person_id is None else f"person {person_id}"
