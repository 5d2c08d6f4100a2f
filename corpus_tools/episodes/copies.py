"""People's language in copies of datasets: what all formats share."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeAlias

from corpus_tools.lerobot.language_rows import TASK_AUG, Language
from corpus_tools.lerobot.language_writing import EpisodeLanguage
from corpus_tools.runtime.atomic_folder import write_folder
from g3.errors import FormatError
from g3.storage.system_errors import about

PEOPLE = "people.jsonl"
"""The file of a copy with the source of each text."""
Files: TypeAlias = dict[str, bytes | Path]
"""Contents by name, or the files that hold them."""


@dataclass(frozen=True, slots=True)
class LanguageCopy:
    """A copy of a dataset, and the language that is put into it."""

    target: Path
    """The copy's folder, whose parent must be there."""
    language: Mapping[int, EpisodeLanguage]
    """By the numbers of episodes; the others keep what they have."""
    attachments: Mapping[str, bytes]
    """Further files by name; `PEOPLE` is among them."""
    rates: Mapping[int, float] = field(default_factory=dict)
    """Frames a second at which each episode was shown, where they are known."""
    starts: Mapping[int, int] = field(default_factory=dict)
    """The time of the first picture of each recording, in nanoseconds."""
    force: bool = False
    """True to replace an older copy."""

    @contextmanager
    def writing(self, source: Path, marker: str = PEOPLE) -> Iterator[tuple[Path, Files]]:
        """Yield a folder on the target's disk, and the files of the copy, to be filled in.

        They are written at the end: all of them or, on any error, nothing. A CorpusError says that
        the copy would lie in the dataset, or can't be written.
        """
        resolved = self.target.resolve()
        if source == resolved or source in resolved.parents:
            what, fix = "the copy would lie in the dataset itself", "name a folder elsewhere"
            raise FormatError(
                what, where=str(self.target), fix=f"{fix}: the dataset stays as it is"
            )
        files: Files = {}
        with (
            about(self.target),
            TemporaryDirectory(dir=self.target.parent, prefix=".copy-") as scratch,
            about(self.target, instead_of=scratch),
        ):
            yield Path(scratch), files
            every = files | dict(self.attachments)
            write_folder(self.target, every, force=self.force, marker=marker)

    def check_written(self, source: Path, seen: Collection[int]) -> None:
        """Raise a FormatError if a dataset has none of the language's episodes."""
        if self.language and not self.language.keys() & seen:
            what = f"the dataset has no episode {min(self.language)}, nor any other of these"
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
