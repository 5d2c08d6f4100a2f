"""Numbers in answers, with their limits."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import msgspec

from annotation_app.store.models import Record

Seconds: TypeAlias = Annotated[float, msgspec.Meta(ge=0, le=1e6)]
Coordinate: TypeAlias = Annotated[float, msgspec.Meta(ge=-1e6, le=1e6)]


def with_watching(body: Record, watched_s: float | None) -> Record:
    """A kept answer with the time that videos were played for, if the page has told it."""
    return body if watched_s is None else {**body, "watched_s": watched_s}
