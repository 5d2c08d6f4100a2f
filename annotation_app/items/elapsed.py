"""Elapsed time that stays right when the machine's clock is set meanwhile.

Clocks are set forward and back: by people, by the network, after a battery died. The time since
the machine's boot goes on evenly. It can be compared with a reading of the same boot only, so each
reading comes with the boot's name.
"""

from __future__ import annotations

import functools
import secrets
import time
from datetime import datetime, timezone
from pathlib import Path

from annotation_app.store.models import Record

LONGEST_S = 7 * 24 * 3600.0
"""Durations beyond this are unknown if they come from the clock alone."""

_BOOT_ID = Path("/proc/sys/kernel/random/boot_id")


def since_boot() -> Record:
    """Return boot name and uptime for :class:`~annotation_app.store.models.Handout`."""
    return {"boot": boot(), "since_boot_s": _since_boot_s()}


@functools.cache
def boot() -> str:
    """Return the name of this run of the machine; where it has none, one for this process."""
    try:
        return _BOOT_ID.read_text().strip()
    except OSError:
        return f"process {secrets.token_hex(16)}"


def _since_boot_s() -> float:
    if hasattr(time, "CLOCK_BOOTTIME"):  # goes on while the machine sleeps
        return time.clock_gettime(time.CLOCK_BOOTTIME)
    return time.monotonic()


def iso(seconds: float) -> str:
    """Return a time in UTC as in ISO 8601."""
    return datetime.fromtimestamp(seconds, timezone.utc).isoformat(timespec="milliseconds")
