"""Parts of answers on which people may disagree, to be counted over a whole study."""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

Key: TypeAlias = tuple[str, Any]
"""A kind of choice, and what was chosen: the name of a thing, the number of a place, corners."""
CLAUSE_TYPE, WORDS, THING, PLACE, AREA = "clause type", "words", "thing", "place", "area"


class Part(NamedTuple):
    """Something that people decided, and whether they decided differently.

    Parameters
    ----------
    kind
        `CLAUSE_TYPE`, `WORDS`, `THING` or `PLACE`.
    what
        A type, words in small letters, the name of a thing, the number of a place.
    video
        Where the thing or place is; empty for what is in no video.
    """

    kind: str
    what: str
    differs: bool
    video: str = ""
