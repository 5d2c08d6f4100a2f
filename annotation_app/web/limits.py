"""Limits on the frequency of actions, counted by person, else by address."""

from __future__ import annotations

import functools
import math
import threading
import time
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Callable
from typing import ParamSpec, TypeVar

import flask
from limits import RateLimitItem, parse_many
from limits.errors import StorageError
from limits.storage import MovingWindowSupport, Storage, storage_from_string
from limits.strategies import MovingWindowRateLimiter
from werkzeug.exceptions import TooManyRequests

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


FORGET_S = 60.0
"""Interval between the removals of old entries, in seconds."""


class ProcessStorage(Storage, MovingWindowSupport):
    """Counts in the memory of one process, under one lock; the URL is ``process://``."""

    STORAGE_SCHEME = ["process"]  # noqa: RUF012 - the base class says so

    def __init__(self, uri: str | None = None, wrap_exceptions: bool = False, **_: str) -> None:
        self._lock = threading.RLock()
        self._ends: dict[str, list[float]] = defaultdict(list)  # until when each thing counts
        self._forgot_at = 0.0
        super().__init__(uri, wrap_exceptions=wrap_exceptions)

    @property
    def base_exceptions(self) -> type[Exception]:
        """Exceptions that the storage may raise."""
        return ValueError

    def acquire_entry(self, key: str, limit: float, expiry: float, amount: int = 1) -> bool:
        """Count something, unless the limit is reached; whether it was counted."""
        with self._lock:
            ends = self._counting(key)
            if len(ends) + amount > limit:
                return False
            ends += [time.monotonic() + expiry] * amount
            return True

    def get_moving_window(self, key: str, limit: int, expiry: int) -> tuple[float, int]:
        """Return the time of the oldest hit that counts, and the number of hits."""
        with self._lock:
            ends = self._counting(key)
            return _by_clock(ends[0] - expiry if ends else time.monotonic()), len(ends)

    def incr(self, key: str, expiry: float, amount: int = 1) -> int:
        """Count a hit, and return the number of hits."""
        with self._lock:
            self.acquire_entry(key, float("inf"), expiry, amount)
            return self.get(key)

    def get(self, key: str) -> int:
        """Return the count of a key."""
        with self._lock:
            return len(self._counting(key))

    def get_expiry(self, key: str) -> float:
        """Return the time when the oldest hit stops to count."""
        with self._lock:
            return _by_clock(next(iter(self._counting(key)), time.monotonic()))

    def check(self) -> bool:
        """Check that the storage works."""
        return True

    def reset(self) -> int:
        """Forget everything, and return the number of keys."""
        with self._lock:
            count = len(self._ends)
            self._ends.clear()
            return count

    def clear(self, key: str) -> None:
        """Forget what somebody did."""
        with self._lock:
            self._ends.pop(key, None)

    def _counting(self, key: str) -> list[float]:
        """Return the ends of the hits that still count, oldest first."""
        now = time.monotonic()
        if now - self._forgot_at >= FORGET_S:
            self._forgot_at = now
            for other in [other for other, ends in self._ends.items() if ends[-1:] <= [now]]:
                del self._ends[other]
        ends = self._ends[key]
        del ends[: bisect_right(ends, now)]
        return ends


def _by_clock(moment: float) -> float:
    # The package compares with the clock.
    return moment - time.monotonic() + time.time()
