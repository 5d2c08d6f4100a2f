"""What practice examples are about: a made-up scene at sea, which puts no words into mouths."""

from __future__ import annotations

import functools
from importlib import resources
from typing import Any

import msgspec

from annotation_app.core.languages import N_, gettext
from annotation_app.store.models import Record
from annotation_app.tasks.clause_words import clauses_of, words_of
from g3.sdc.sdc_notation import from_json

# Translators: seven words of the same kinds in the same order; without, people see the English.
COMMAND = N_("Sail to the buoy by the lighthouse.")


class PracticeExample(msgspec.Struct, frozen=True):
    """What there is to make a task's practice example of."""

    command: str
    """What somebody has typed for the video."""
    words: list[dict[str, Any]]
    """Its words, and where each starts."""
    sdcs: list[Record]
    """Its SDC trees, as :func:`g3.sdc.sdc_notation.to_json` writes them."""
    clauses: list[Record]
    """Node, type and phrase of each clause that words name."""
    watched: Record
    """What a page needs to show the video."""
    scene: Record
    """The same, with outlines and a map."""


def practice_example() -> PracticeExample:
    """The example with its command in the language that is spoken."""
    return _reworded(_written(), gettext(COMMAND))


@functools.cache
def _written() -> PracticeExample:
    """The scene that ``python docs/make_practice.py`` has written."""
    file = resources.files("annotation_app.tasks") / "practice.json"
    return msgspec.json.decode(file.read_bytes(), type=PracticeExample)


def _reworded(example: PracticeExample, command: str) -> PracticeExample:
    """The example with another command, word for word; as it is if the numbers of words differ."""
    words = list(words_of(command))
    if len(words) != len(example.words):
        return example
    new = {old["start"]: word for old, word in zip(example.words, words, strict=True)}

    def worded(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: worded(part) for key, part in value.items()}
        if isinstance(value, list) and value and isinstance(value[0], str):
            return [new[value[1]]["text"], new[value[1]]["start"]]
        return [worded(part) for part in value] if isinstance(value, list) else value

    sdcs = worded(example.sdcs)
    return msgspec.structs.replace(
        example,
        command=command,
        words=words,
        sdcs=sdcs,
        clauses=clauses_of(from_json(sdcs)),
    )
