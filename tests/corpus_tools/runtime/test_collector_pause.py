"""The search for cycles pauses, and goes on afterwards if it went on before."""

from __future__ import annotations

import gc

import pytest

from corpus_tools.runtime.collector_pause import collector_paused


def test_goes_on_after_an_error() -> None:
    assert gc.isenabled()
    seen = []

    @collector_paused()
    def read() -> None:
        seen.append(gc.isenabled())
        raise ValueError("unreadable")

    with pytest.raises(ValueError, match="unreadable"):
        read()
    assert seen == [False]
    assert gc.isenabled()


def test_a_pause_in_a_pause_does_not_end_it() -> None:
    with collector_paused():
        with collector_paused():
            pass
        assert not gc.isenabled()
    assert gc.isenabled()
