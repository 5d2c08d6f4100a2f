"""SDC trees that the parser proposes for a command."""

from __future__ import annotations

import functools
import threading

from annotation_app.store.models import Record
from g3.sdc.sdc_notation import to_json

_ONE_AT_A_TIME = threading.Lock()
"""So that the parser isn't read twice."""


def warm_up() -> None:
    """Read the parser before somebody waits for it, in the background."""
    threading.Thread(target=suggest, args=("Go.",), daemon=True).start()


@functools.lru_cache(maxsize=1000)
def suggest(text: str) -> list[Record] | None:
    """Return a command's clauses as JSON; None if it has none."""
    from g3.language.parsing.sdc_parser import default_parser  # noqa: PLC0415 - slow to import

    with _ONE_AT_A_TIME:
        [sdcs] = default_parser().predict([text])
    return to_json(sdcs) or None
