"""A corpus in memory."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, overload

from corpus_tools.corpus.corpus_entries import Entry, entries, entries_table
from g3 import html_view
from g3.annotation import Annotation, Command, Judgment, TaskOutcome
from g3.groundings import Context
from g3.short_repr import brief

if TYPE_CHECKING:
    import pandas as pd

SAMPLE = 8
"""Number of commands that a notebook shows of a corpus, spread over all of it."""


@dataclass(frozen=True, slots=True)
class Corpus:
    """Commands, the worlds they were given in, their annotations and judgments.

    ``len(corpus)`` is the number of its commands. Iterating gives each with all that is known of
    it (:class:`~corpus_tools.corpus.corpus_entries.Entry`); so do ``corpus[0]`` and ``corpus[id]``.

    Make one with :func:`corpus_tools.corpus.encoding.make_corpus`, which computes the
    hash, or read one with :func:`corpus_tools.corpus.corpus_reading.load_corpus`.
    """

    name: str
    """Name of the corpus."""
    contexts: Mapping[str, Context]
    commands: Mapping[str, Command]
    """By id. Every command that was typed is there, annotated or not."""
    annotations: tuple[Annotation, ...]
    """Each shares the instances of its command and its context, and of the context's objects where
    its groundings are those objects."""
    judgments: tuple[Judgment, ...]
    """People's ratings of commands shown with videos."""
    source: str
    """Origin of the data."""
    licence: str
    """Terms of use."""
    hash: str
    """``sha256:`` and the digest of the content without the subjects. It doesn't depend on the salt
    that hides the subjects, nor on the corpus's name."""
    outcomes: tuple[TaskOutcome, ...] = ()
    """Executions by the robot, where a log shows them; those of a video are in their order."""
    _entries: list[Entry] = field(default_factory=list, init=False, repr=False, compare=False)

    def __len__(self) -> int:
        """Return the number of commands."""
        return len(self.commands)

    def __iter__(self) -> Iterator[Entry]:
        """Yield the commands, each with its annotations, context and outcomes."""
        return iter(self._all())

    @overload
    def __getitem__(self, which: int | str) -> Entry: ...
    @overload
    def __getitem__(self, which: slice) -> list[Entry]: ...
    def __getitem__(self, which: int | str | slice) -> Entry | list[Entry]:
        """Return a command by its number or its id, or several by a slice."""
        if isinstance(which, str) and which not in self.commands:
            like = next(iter(self.commands), "")
            raise KeyError(f"there is no command {which!r}; ids are like {like!r}")
        if isinstance(which, str):
            return self._all()[list(self.commands).index(self.commands[which].id)]
        return self._all()[which]

    def __contains__(self, which: object) -> bool:
        """Check for a command by its id, or for an entry."""
        return which in self.commands if isinstance(which, str) else which in self._all()

    def _all(self) -> list[Entry]:
        if len(self._entries) != len(self.commands):
            found = entries(self.commands, self.annotations, self.contexts, self.outcomes)
            self._entries[:] = found
        return self._entries

    def to_pandas(self) -> pd.DataFrame:
        """Make a table with a row for each command."""
        return entries_table(self)

    def _counts(self) -> tuple[str, ...]:
        held = (self.contexts, self.commands, self.annotations, self.judgments, self.outcomes)
        names = ("contexts", "commands", "annotations", "judgments", "outcomes")
        return tuple(
            f"{len(things)} {name}" for things, name in zip(held, names, strict=True) if things
        )

    def __repr__(self) -> str:
        return f"Corpus({', '.join((brief(self.name), *self._counts()))})"

    def _repr_html_(self) -> str:
        """Return the corpus's source, its counts and some of its commands as HTML."""
        step = max(1, len(self) // SAMPLE)
        rows = [(e.id, e.text, "yes" if e.annotations else "no") for e in self[::step][:SAMPLE]]
        return "\n".join(
            [
                html_view.heading(f"Corpus {self.name}", *self._counts()),
                html_view.paragraph(f"{self.source} · {self.licence}"),
                html_view.table(("id", "command", "annotated"), rows),
            ]
        )
