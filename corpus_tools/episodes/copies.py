"""People's language in copies of datasets: what all formats share."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from corpus_tools.lerobot.language_rows import TASK_AUG, Language
from corpus_tools.lerobot.language_writing import EpisodeLanguage
from g3.errors import FormatError

PEOPLE = "people.jsonl"
"""The file of a copy with the source of each text."""


def check_outside(source: Path, target: Path) -> None:
    """Raise a FormatError if a copy would lie in the dataset itself."""
    resolved = target.resolve()
    if source == resolved or source in resolved.parents:
        fix = "name a folder elsewhere: the dataset stays as it is"
        raise FormatError("the copy would lie in the dataset itself", where=str(target), fix=fix)


def check_written(source: Path, language: Mapping[int, EpisodeLanguage], seen: set[int]) -> None:
    """Raise a FormatError if a dataset has none of the episodes that the language is about."""
    if language and not seen & language.keys():
        what = f"the dataset has no episode {min(language)}, nor any other of these"
        fix = "name the dataset that the language is about"
        raise FormatError(what, where=str(source), fix=fix)


def wordings(added: EpisodeLanguage) -> list[str]:
    """Return the descriptions of an episode."""
    return list(dict.fromkeys(item.text for item in added.said if item.style == TASK_AUG))


def records(items: Sequence[Language], fps: float = 0.0) -> list[dict[str, Any]]:
    """Return texts in the order of their beginnings, with frames if the rate is known."""
    return [
        {
            "style": item.style,
            "start_s": round(item.start_s, 6),
            **({"step": round(item.start_s * fps)} if fps else {}),
            "content": item.text,
            **item.of_event(),
        }
        for item in sorted(items, key=lambda item: item.start_s)
    ]


def style_counts(language: Mapping[int, EpisodeLanguage]) -> Mapping[str, int]:
    """Return the number of texts of each style."""
    return Counter(item.style for added in language.values() for item in added.said)
