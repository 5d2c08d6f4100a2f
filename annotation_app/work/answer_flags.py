"""Oddities of a single answer, as far as the answer itself shows them.

A flag is a reason to look, not a verdict: exports and the dashboard's page of people show it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from annotation_app.store.models import Record

QUICK_S, QUICK_WORD_S = 2.0, 0.5
"""Seconds, in all and per word, below which nobody can have read a command and its suggestion:
people read some four words a second."""
SLACK_S = 2.0
"""Players round, and a page's clock doesn't begin with the server's."""
MARGIN = 1e-3

UNREAD = "unchanged suggestion, sent before it could be read"
WATCHED_LONGER = "watched longer than the item was there"
UNWATCHED = "sent without watching the video to its end"


def is_untouched(provenance: Record | None) -> bool:
    """Check that an answer is a suggestion that was shown and sent unchanged."""
    return (
        provenance is not None
        and provenance["suggestion"] == "shown"
        and bool(provenance["unchanged"])
    )


def watched_too_long(body: Record, seconds: float | None) -> bool:
    """Check that an answer reports more watching than its seconds allow, None if unknown."""
    # Who says nothing of the speed had no choice of it.
    allowed = math.inf if seconds is None else seconds * body.get("speed", 1.0) + SLACK_S
    return bool(body.get("watched_s", 0.0) > allowed)


def odd_below(payload: Record, body: Record, provenance: Record | None) -> float | None:
    """Return the seconds from which on :func:`answer_flags` surely finds nothing odd.

    It is a little longer than need be, so that rounding doesn't matter. Parameters are as there.

    It is None where the answer may be odd however long it took.
    """
    if body.get("unwatched"):
        return None
    words = len(payload.get("text", "").split())
    read = QUICK_S + QUICK_WORD_S * words if is_untouched(provenance) else 0.0
    watched = (body.get("watched_s", 0.0) - SLACK_S) / body.get("speed", 1.0)
    found = max(read, watched) * (1 + MARGIN) + MARGIN
    return found if math.isfinite(found) else None


def answer_flags(
    payload: Record, body: Record, provenance: Record | None, seconds: float | None
) -> Iterator[str]:
    """Yield oddities of an answer to an item that took a person some seconds, None if unknown."""
    if body.get("unwatched"):
        yield UNWATCHED
    if seconds is None:
        return
    words = len(payload.get("text", "").split())
    if is_untouched(provenance) and seconds < QUICK_S + QUICK_WORD_S * words:
        yield UNREAD
    if watched_too_long(body, seconds):
        yield WATCHED_LONGER
