"""Ending a server by a signal: the first one asks it to finish, the second one ends it at once."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

SIGNALS = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def asked_to_end(ring: Callable[[], None]) -> Iterator[threading.Event]:
    """An event that is set, and rings, when Ctrl-C is pressed or the process asked to end.

    Also where a shell has started the process in the background, and so made it ignore Ctrl-C.
    """
    event = threading.Event()
    if threading.current_thread() is not threading.main_thread():  # others get no signals
        yield event
        return

    def ask(_number: int, _frame: Any) -> None:
        for number in SIGNALS:
            signal.signal(number, signal.SIG_DFL)
        event.set()
        ring()

    before = {number: signal.signal(number, ask) for number in SIGNALS}
    try:
        yield event
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
