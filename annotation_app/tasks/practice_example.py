"""What practice examples are about: a made-up scene at sea, which puts no words into mouths."""

from __future__ import annotations

import functools
from importlib import resources
from typing import Any

import msgspec

from annotation_app.store.models import Record


class PracticeExample(msgspec.Struct, frozen=True):
    """What there is to make a task's practice example of.

    Parameters
    ----------
    command
        What somebody has typed for the video.
    words
        Its words, and where each starts.
    sdcs
        Its SDC trees, as :func:`g3.sdc.sdc_notation.to_json` writes them.
    clauses
        Node, type and phrase of each clause that words name.
    watched
        What a page needs to show the video.
    scene
        The same, with outlines and a map.
    """

    command: str
    words: list[dict[str, Any]]
    sdcs: list[Record]
    clauses: list[Record]
    watched: Record
    scene: Record


@functools.cache
def practice_example() -> PracticeExample:
    """The scene that ``python docs/make_practice.py`` has written."""
    file = resources.files("annotation_app.tasks") / "practice.json"
    return msgspec.json.decode(file.read_bytes(), type=PracticeExample)
