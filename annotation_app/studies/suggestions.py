"""SDC trees that the parser proposes for a command, and the words that it is sure of."""

from __future__ import annotations

import functools
import threading

import numpy as np

from annotation_app.store.models import Record
from g3.sdc.sdc_notation import to_json

SURE = 0.9
"""Probability from which a word is taken to say what to do."""
_ONE_AT_A_TIME = threading.Lock()
"""So that the parser isn't read twice."""


def warm_up() -> None:
    """Read the parser before somebody waits for it, in the background."""
    threading.Thread(target=suggest, args=("Go.",), daemon=True).start()


@functools.lru_cache(maxsize=1000)
def suggest(text: str) -> tuple[list[Record], float] | None:
    """Return a command's clauses as JSON, and their probability; None if it has none."""
    from g3.language.parsing.sdc_parser import default_parser  # noqa: PLC0415 - slow to import

    with _ONE_AT_A_TIME:
        [found] = default_parser().predict_proba([text])
    return (to_json(found.sdcs), found.trees[0].probability) if found.trees else None


@functools.lru_cache(maxsize=1000)
def action_starts(text: str) -> frozenset[int]:
    """Return where the words begin with which a clause begins that says what to do."""
    from g3.language.parsing.arc_model import log_probabilities  # noqa: PLC0415 - slow to import
    from g3.language.parsing.sdc_parser import TEMPERATURE, default_parser  # noqa: PLC0415
    from g3.language.parsing.words import cut  # noqa: PLC0415 - as above

    with _ONE_AT_A_TIME:
        parser, command = default_parser(), cut(text)
        [vectors] = parser.encoder_.encode_all([command])
    if not command.spans:
        return frozenset()
    labels = [label.split("/")[0].split("^")[0] for label in parser.arcs_.labels]
    says = np.array([label.endswith(":EVENT") for label in labels])
    arcs = np.exp(log_probabilities(parser.arcs_, vectors, TEMPERATURE))
    chances = arcs[:, :, says].sum(axis=(1, 2))
    pairs = zip(command.spans, chances, strict=False)  # of a very long text the first words
    return frozenset(span.start for span, chance in pairs if chance >= SURE)
