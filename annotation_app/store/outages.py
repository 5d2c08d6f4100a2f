"""Outages of the database: people are asked to wait.

Nothing of this is a bug of the program: the log gets a line a minute and no tracebacks. Browsers
keep answers and send them again.
"""

from __future__ import annotations

import errno
import logging
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

from sqlalchemy.exc import DBAPIError, OperationalError
from sqlalchemy.exc import TimeoutError as NoConnectionLeft

from annotation_app.core.languages import N_
from g3.errors import FormatError

log = logging.getLogger(__name__)

TITLE = N_("The study can't be reached at the moment.")
ADVICE = N_(
    "Nothing is lost: answers that you have sent wait in your browser, and are sent by themselves "
    "when the study is back. Try again in a minute."
)
AGAIN_S = 10
"""Time after which browsers try again, in seconds."""
TELL_S = 60.0
"""Interval between entries in the log about an outage, in seconds."""
QUIET_S = 5.0
"""Time without failures after which an outage is over, in seconds."""

LONGEST_REASON = 200


class OnlyReadError(FormatError):
    """A database that can't be written to."""

    def __init__(self, file: str, what: str = "the database can only be read") -> None:
        fix = "get the right to write to it and to its folder, or work on a copy of all its files"
        super().__init__(what, where=file, fix=fix)


@dataclass(frozen=True, slots=True)
class Outage:
    """Reason why something can't be done for a while."""

    kind: str
    """Kind of the outage, for counting."""
    reason: str
    """Message of the system or the driver."""


def outage_of(error: BaseException) -> Outage | None:
    """Return the outage outside of the program that caused an error, if any."""
    if isinstance(error, NoConnectionLeft):
        return Outage("all connections to the database are in use", "")
    if isinstance(error, OnlyReadError):
        return Outage(READ_ONLY, "")
    if isinstance(error, OSError):
        kind = _SYSTEM.get(error.errno or 0)
        return None if kind is None else Outage(kind, error.strerror or "")
    if not isinstance(error, DBAPIError) or error.orig is None:
        return None
    if isinstance(error.orig, OSError):  # of the file with which SQLite's writers take turns
        return outage_of(error.orig) or Outage(UNREACHABLE, error.orig.strerror or "")
    kind = _kind(error)
    lines = str(error.orig).strip().splitlines() or [type(error.orig).__name__]
    return None if kind is None else Outage(kind, lines[0][:LONGEST_REASON])


def named_outage(error: BaseException, database: str) -> FormatError | None:
    """Return an outage's error for commands, with a remedy; None if it is no outage.

    `database` is its file or address, without a password.
    """
    outage = outage_of(error)
    if outage is None:
        return None
    reason = f": {outage.reason}" if outage.reason else ""
    fix = _FIXES.get(outage.kind, "try again when fewer programs use it")
    return FormatError(f"{outage.kind}{reason}", where=database, fix=fix)


UNREACHABLE = "the database can't be reached"
FULL = "the disk is full"
READ_ONLY = "the database can't be written to"
DAMAGED = "the database is damaged"
BUSY = "the database is too busy"
BROKEN = "the disk can't be read or written"

_FIXES = {
    UNREACHABLE: "start it, or correct --database or --instance, then run the command again",
    FULL: "make room on the disk of the database, then run the command again",
    READ_ONLY: "get the right to write to it and to its folder",
    DAMAGED: "restore a backup with `ct annotate restore` into a new instance",
    BROKEN: "check the disk of the database, and make room there",
}

_SYSTEM = {
    errno.ENOSPC: FULL,
    errno.EDQUOT: FULL,
    errno.EROFS: READ_ONLY,
    errno.EIO: BROKEN,
    errno.EMFILE: "too many files are open",
    errno.ENFILE: "too many files are open",
}
_SQLITE = {
    "database is locked": BUSY,
    "database table is locked": BUSY,
    "locking protocol": BUSY,
    "unable to open database file": UNREACHABLE,
    "database or disk is full": FULL,
    "disk I/O error": BROKEN,
    "attempt to write a readonly database": READ_ONLY,
    "database disk image is malformed": DAMAGED,
    "file is not a database": DAMAGED,
}
"""Beginnings of SQLite's messages: Python 3.10 doesn't give its codes."""
_STATES = {
    "53100": FULL,
    "53": BUSY,  # connections, memory
    "25006": READ_ONLY,
    "40": BUSY,  # deadlocks, and others that would have gone well a moment later
    "55": BUSY,  # locks
    "58": BROKEN,
    "XX001": DAMAGED,
    "XX002": DAMAGED,
}
"""SQLSTATE codes of PostgreSQL, or the classes that they begin with."""


def _kind(error: DBAPIError) -> str | None:
    message = str(error.orig)
    for beginning, kind in _SQLITE.items():
        if message.startswith(beginning):
            return kind
    state = getattr(error.orig, "sqlstate", None)
    if isinstance(state, str):
        for code in (state, state[:2]):
            if code in _STATES:
                return _STATES[code]
    is_sqlite = type(error.orig).__module__ == "sqlite3"  # whose other such errors are bugs
    is_outside = isinstance(error, OperationalError) or error.connection_invalidated
    return UNREACHABLE if is_outside and not is_sqlite else None


@dataclass(slots=True)
class _Going:
    """A lasting outage: when it began and was last met, how often, and what the log knows."""

    since: float
    last_at: float
    told_at: float
    count: int = 1
    told: int = 1


class Outages:
    """Logs what goes wrong outside of the program, once a minute, and when it is over."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._going: dict[str, _Going] = {}

    def failed(self, outage: Outage) -> None:
        """Count something that couldn't be done."""
        with self._lock:
            now = self._clock()
            reason = f" ({outage.reason})" if outage.reason else ""
            going = self._going.get(outage.kind)
            if going is None:
                self._going[outage.kind] = _Going(now, now, now)
                log.error("%s%s; it is tried again with each request", outage.kind, reason)
                return
            going.last_at = now
            going.count += 1
            if now - going.told_at >= TELL_S:
                new, seconds = going.count - going.told, now - going.told_at
                going.told_at, going.told = now, going.count
                log.error("%s%s: %d more times in %.0f s", outage.kind, reason, new, seconds)

    def worked(self) -> None:
        """Take note that something was written, so that outages are over."""
        if not self._going:  # nearly always, and without waiting for others
            return
        with self._lock:
            now = self._clock()
            for kind, going in list(self._going.items()):
                if now - going.last_at >= QUIET_S:
                    lasted = going.last_at - going.since
                    log.warning("over after %.0f s: %s (%d times)", lasted, kind, going.count)
                    del self._going[kind]
