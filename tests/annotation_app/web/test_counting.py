"""Limits are kept by threads that count at once."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import pytest
from limits import parse
from limits.storage import storage_from_string
from limits.strategies import MovingWindowRateLimiter

from annotation_app.web import limits as counting


def test_threads_count_together() -> None:
    limiter, limit = MovingWindowRateLimiter(counting.ProcessStorage()), parse("100/minute")
    with ThreadPoolExecutor(16) as pool:
        allowed = list(pool.map(lambda _: limiter.hit(limit, "ann"), range(400)))
    assert sum(allowed) == 100
    assert not limiter.test(limit, "ann")
    assert limiter.test(limit, "bob")
    assert limiter.get_window_stats(limit, "ann").remaining == 0
    limiter.clear(limit, "ann")
    assert limiter.hit(limit, "ann")


def test_what_is_old_does_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [1000.0]
    monkeypatch.setattr("annotation_app.web.limits.time.time", lambda: clock[0])
    monkeypatch.setattr("annotation_app.web.limits.time.monotonic", lambda: clock[0])
    storage = counting.ProcessStorage()
    assert [storage.acquire_entry("ann", 2, 60) for _ in range(3)] == [True, True, False]
    clock[0] += 30
    assert storage.get_moving_window("ann", 2, 60) == (1000.0, 2)
    assert storage.get_expiry("ann") == 1060.0
    clock[0] += 30
    assert storage.acquire_entry("ann", 2, 60)
    assert storage.get("ann") == 1
    clock[0] += 1000
    assert storage.acquire_entry("bob", 2, 60)
    assert storage.reset() == 1  # nothing is kept of Ann


def test_its_address() -> None:
    assert isinstance(storage_from_string("process://"), counting.ProcessStorage)
