"""Making many objects without the search for cycles among them."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def collector_paused() -> Iterator[None]:
    """Don't look for cycles meanwhile.

    Python's collector visits all objects again and again while millions are being made. What is
    in no cycle, such as the records of a file, is freed without it.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
