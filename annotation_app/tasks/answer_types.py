"""Numbers in answers, with their limits."""

from __future__ import annotations

from typing import Annotated, Any, TypeAlias

import msgspec

from annotation_app.store.models import Record

Seconds: TypeAlias = Annotated[float, msgspec.Meta(ge=0, le=1e6)]
Speed: TypeAlias = Annotated[float, msgspec.Meta(gt=0, le=4)]
"""How fast a video may be played: the player offers up to 4 times."""
Coordinate: TypeAlias = Annotated[float, msgspec.Meta(ge=-1e6, le=1e6)]


def with_watching(body: Record, answer: Any) -> Record:
    """A kept answer with what the page has reported of watching.

    That is ``watched_s``, seconds of videos that were played, at any speed, and ``speed``, the
    fastest that they were played at.
    """
    told = {"watched_s": answer.watched_s, "speed": answer.speed}
    return body | {name: value for name, value in told.items() if value is not None}
