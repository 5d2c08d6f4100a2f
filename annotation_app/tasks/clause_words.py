"""Words and clauses of commands, as pages get them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from annotation_app.store.models import Record
from g3.sdc.clauses import SDC, all_words, breadth_first

WORD = re.compile(r"\w+(?:[-'’]\w+)*|[^\w\s]")
HAPPENING = ("EVENT", "PATH")
"""The types of clauses that say what happens, which videos show."""


def words_of(text: str) -> Iterator[dict[str, Any]]:
    """The words of a command and where each starts."""
    return ({"start": m.start(), "text": m[0]} for m in WORD.finditer(text))


def phrase_of(sdc: SDC) -> str:
    """All words of a clause."""
    return " ".join(word.text for word in all_words(sdc))


def clauses_of(sdcs: tuple[SDC, ...]) -> list[Record]:
    """The clauses that words name: ``node`` (breadth first), ``type`` and ``phrase``."""
    return [
        {"node": node, "type": sdc.type, "phrase": phrase_of(sdc)}
        for node, sdc in enumerate(breadth_first(sdcs))
        if not sdc.is_implicit
    ]
