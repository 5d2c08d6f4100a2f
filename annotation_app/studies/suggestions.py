"""SDC trees that the parser proposes for a command, and the words that it is sure or unsure of."""

from __future__ import annotations

import functools
import threading
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from annotation_app.store.models import Record
from g3.sdc.sdc_notation import to_json

SURE = 0.9
"""Probability from which a word is taken to say what to do."""
ASKED = 0.95
"""Probability of a word's place below which people are asked about it."""
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


@dataclass(frozen=True, slots=True)
class Certainty:
    """Where words begin of which the parser is sure or unsure.

    Parameters
    ----------
    actions, things
        First words of clauses that surely are an EVENT or an OBJECT.
    wheres
        First words of clauses that more probably than not are a PLACE or a PATH.
    unsure
        Words whose place in the most probable tree is less probable than `ASKED`.
    """

    actions: frozenset[int] = frozenset()
    things: frozenset[int] = frozenset()
    wheres: frozenset[int] = frozenset()
    unsure: frozenset[int] = frozenset()


@functools.lru_cache(maxsize=1000)
def certainty(text: str) -> Certainty:
    """Return which words of a command the parser is sure and unsure of."""
    from g3.language.parsing.arc_decoding import likely_arcs  # noqa: PLC0415 - slow to import
    from g3.language.parsing.arc_model import log_probabilities  # noqa: PLC0415
    from g3.language.parsing.sdc_parser import TEMPERATURE, default_parser  # noqa: PLC0415
    from g3.language.parsing.words import cut  # noqa: PLC0415 - as above

    with _ONE_AT_A_TIME:
        parser, command = default_parser(), cut(text)
        [vectors] = parser.encoder_.encode_all([command])
    if not command.spans:
        return Certainty()
    names = parser.arcs_.labels
    scores = log_probabilities(parser.arcs_, vectors, TEMPERATURE)
    _, best = next(likely_arcs(scores, names))
    labels = [label.split("/")[0].split("^")[0] for label in names]

    def likely(least: float, *types: str) -> frozenset[int]:
        of = np.array([label.endswith(tuple(f":{one}" for one in types)) for label in labels])
        return starts(np.exp(scores)[:, :, of].sum(axis=(1, 2)) >= least)

    def starts(of: npt.NDArray[np.bool_]) -> frozenset[int]:
        pairs = zip(command.spans, of, strict=False)  # of a very long text the first words
        return frozenset(span.start for span, is_so in pairs if is_so)

    places = [
        scores[word, head + 1, names.index(label)]
        for word, (head, label) in enumerate(zip(*best, strict=True))
    ]
    return Certainty(
        actions=likely(SURE, "EVENT"),
        things=likely(SURE, "OBJECT"),
        wheres=likely(0.5, "PLACE", "PATH"),
        unsure=starts(np.exp(np.array(places)) < ASKED),
    )
