"""Counting requests in a process of many threads, for the limits on how often people do things.

The storage that comes with ``limits`` goes by the machine's clock. Where that is set back, what
was done before counts until the clock is there again; here it counts for as long as it should.
"""

from __future__ import annotations

import threading
import time
from bisect import bisect_right
from collections import defaultdict

from limits.storage import MovingWindowSupport, Storage

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
