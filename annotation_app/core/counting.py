"""Counting requests in a process of many threads, for the limits on how often people do things.

The storage that comes with ``limits`` starts a thread to forget what is old, and two
requests at once may start the same one, which fails. It also goes by the machine's clock: where
that is set back, what was done before counts until the clock is there again.
"""

from __future__ import annotations

import threading
import time
from bisect import bisect_right
from dataclasses import dataclass, field

from limits.storage import MovingWindowSupport, Storage

FORGET_S = 60.0
"""How often what is old is forgotten."""


@dataclass(slots=True)
class _Window:
    """When somebody did something, oldest first, and how long that counts."""

    expiry_s: float
    times: list[float] = field(default_factory=list)

    def forget(self, now: float) -> None:
        del self.times[: bisect_right(self.times, now - self.expiry_s)]


class ProcessStorage(Storage, MovingWindowSupport):
    """Counts in the memory of one process, under one lock; the URL is ``process://``."""

    STORAGE_SCHEME = ["process"]  # noqa: RUF012 - the base class says so

    def __init__(self, uri: str | None = None, wrap_exceptions: bool = False, **_: str) -> None:
        self._lock = threading.Lock()
        self._windows: dict[str, _Window] = {}
        self._forgot_at = 0.0
        super().__init__(uri, wrap_exceptions=wrap_exceptions)

    @property
    def base_exceptions(self) -> type[Exception]:
        """What can go wrong in it."""
        return ValueError

    def acquire_entry(self, key: str, limit: int, expiry: int, amount: int = 1) -> bool:
        """Count something, unless the limit is reached; whether it was counted."""
        with self._lock:
            now = time.monotonic()
            self._forget(now)
            window = self._window(key, expiry, now)
            if len(window.times) + amount > limit:
                return False
            window.times += [now] * amount
            return True

    def get_moving_window(self, key: str, limit: int, expiry: int) -> tuple[float, int]:
        """When the oldest thing was done that counts, and how many there are."""
        with self._lock:
            now = time.monotonic()
            times = self._window(key, expiry, now).times
            return _by_clock(times[0] if times else now), len(times)

    def incr(self, key: str, expiry: float, amount: int = 1) -> int:
        """Count something; how many there are."""
        with self._lock:
            now = time.monotonic()
            window = self._window(key, expiry, now)
            window.times += [now] * amount
            return len(window.times)

    def get(self, key: str) -> int:
        """How many there are."""
        with self._lock:
            window = self._windows.get(key, _Window(0.0))
            window.forget(time.monotonic())
            return len(window.times)

    def get_expiry(self, key: str) -> float:
        """When the oldest one stops to count."""
        with self._lock:
            window = self._windows.get(key, _Window(0.0))
            return _by_clock(window.times[0] + window.expiry_s) if window.times else time.time()

    def check(self) -> bool:
        """Whether it works."""
        return True

    def reset(self) -> int:
        """Forget everything; how much there was."""
        with self._lock:
            count = len(self._windows)
            self._windows.clear()
            return count

    def clear(self, key: str) -> None:
        """Forget what somebody did."""
        with self._lock:
            self._windows.pop(key, None)

    def _window(self, key: str, expiry: float, now: float) -> _Window:
        window = self._windows.setdefault(key, _Window(expiry))
        window.forget(now)
        return window

    def _forget(self, now: float) -> None:
        if now - self._forgot_at < FORGET_S:
            return
        self._forgot_at = now
        for key, window in list(self._windows.items()):
            window.forget(now)
            if not window.times:
                del self._windows[key]


def _by_clock(moment: float) -> float:
    # The package compares with the clock.
    return moment - time.monotonic() + time.time()
