"""SDC trees that the automatic extractor proposes for a command, where it is installed."""

from __future__ import annotations

import functools
import importlib.util
import threading

from annotation_app.store.models import Record
from g3.errors import CorpusError
from g3.sdc.sdc_notation import to_json

_ONE_AT_A_TIME = threading.Lock()
"""So that the extractor isn't read twice, which takes seconds."""


def warm_up() -> None:
    """Read the extractor before somebody waits for it, in the background."""
    threading.Thread(target=suggest, args=("Go.",), daemon=True).start()


@functools.lru_cache(maxsize=1000)
def suggest(text: str) -> list[Record] | None:
    """Return a command's clauses as JSON; None without an extractor, or without clauses."""
    if importlib.util.find_spec("spacy") is None:
        return None
    from g3.language.parsing.extractor import default_extractor  # noqa: PLC0415 - slow, may be missing

    try:
        with _ONE_AT_A_TIME:
            [sdcs] = default_extractor().predict([text])
    except CorpusError:  # the parser's English isn't installed
        return None
    return to_json(sdcs) or None
