"""A corpus: commands, their worlds, annotations and judgments."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Literal, get_args, overload

import numpy as np

from corpus_tools.corpus import corpus_tables
from corpus_tools.corpus.corpus_entries import (
    Entry,
    contexts_by_command,
    entries,
    entries_table,
)
from corpus_tools.corpus.corpus_records import MANIFEST
from corpus_tools.corpus.decoding import OnProblem, read_files, refuse
from corpus_tools.runtime.atomic_folder import check_target, write_folder
from g3 import html_view
from g3.annotation import Annotation, Command, Judgment, TaskOutcome
from g3.errors import CorpusError, nearest
from g3.groundings import Context
from g3.short_repr import brief

if TYPE_CHECKING:
    import pandas as pd

SAMPLE = 8
"""Number of commands that a notebook shows of a corpus, spread over all of it."""

HELD_OUT = 1 / 3
"""Fraction of the parts that a drawn split holds out, about as in the paper."""

Division = Literal["scenario", "person", "world"]
"""Commands that stay together: those of a scenario, of a person, or of a world (context)."""

INVENTED = ("authored", "simulated-")
"""Beginnings of subjects who saw no video: authors of corpora, and simulated workers."""
_STREAM = 2
"""Stream of random numbers, distinct from others with the same seed."""


@dataclass(frozen=True, slots=True)
class Corpus:
    """Commands, the worlds they were given in, their annotations and judgments.

    ``len(corpus)`` is the number of its commands. Iterating gives each with its annotations, its
    context and its outcomes (:class:`~corpus_tools.corpus.corpus_entries.Entry`); so do
    ``corpus[0]`` and ``corpus[id]``. A corpus doesn't change: :meth:`filter`, :meth:`select`,
    :meth:`split` and :func:`dataclasses.replace` make others.

    Read one with :meth:`load`, or put one together with :meth:`build`.
    """

    name: str
    """Name of the corpus."""
    contexts: Mapping[str, Context]
    commands: Mapping[str, Command]
    """By id. Every command that was typed is there, annotated or not."""
    annotations: tuple[Annotation, ...]
    """Each shares the instances of its command and its context, and of the context's objects where
    its groundings are those objects."""
    judgments: tuple[Judgment, ...] = ()
    """People's ratings of commands shown with videos."""
    source: str = ""
    """Origin of the data."""
    licence: str = ""
    """Terms of use."""
    outcomes: tuple[TaskOutcome, ...] = ()
    """Executions by the robot, where a log shows them; those of a video are in their order."""
    _entries: list[Entry] = field(default_factory=list, init=False, repr=False, compare=False)
    _hash: list[str] = field(default_factory=list, init=False, repr=False, compare=False)

    @classmethod
    def build(
        cls,
        name: str,
        *,
        contexts: Iterable[Context],
        commands: Iterable[Command],
        annotations: Iterable[Annotation],
        judgments: Iterable[Judgment] = (),
        outcomes: Iterable[TaskOutcome] = (),
        source: str = "",
        licence: str = "",
    ) -> Corpus:
        """Put a corpus together."""
        return cls(
            name,
            {context.id: context for context in contexts},
            {command.id: command for command in commands},
            tuple(annotations),
            tuple(judgments),
            source,
            licence,
            tuple(outcomes),
        )

    @classmethod
    def load(cls, path: Path | str, *, on_problem: OnProblem = refuse) -> Corpus:
        """Read a corpus.

        Parameters
        ----------
        path
            Its folder.
        on_problem
            Called with each problem of a record, which is then left out.

        Returns
        -------
        Corpus
            Its annotations share the instances of commands, contexts and objects.

        Raises
        ------
        FormatError
            At the first problem, if no `on_problem` is given; and if the folder can't be read as a
            corpus at all.
        """
        manifest, content, tables = read_files(Path(path), on_problem)
        corpus = cls(
            manifest.name,
            content.contexts,
            content.commands,
            content.annotations,
            content.judgments,
            manifest.source,
            manifest.licence,
            content.outcomes,
        )
        corpus._hash.append(corpus_tables.content_hash(tables))
        return corpus

    @classmethod
    def merge(cls, name: str, corpora: Sequence[Corpus]) -> Corpus:
        """Put the content of corpora into one, in their order.

        Raises
        ------
        CorpusError
            If two of them have the same id.
        """
        for kind, ids in {
            "context": chain.from_iterable(c.contexts for c in corpora),
            "command": chain.from_iterable(c.commands for c in corpora),
            "annotation": (a.id for c in corpora for a in c.annotations),
            "judgment": (j.id for c in corpora for j in c.judgments),
            "outcome": (o.id for c in corpora for o in c.outcomes),
        }.items():
            twice = next((id_ for id_, count in Counter(ids).items() if count > 1), "")
            if twice:
                raise CorpusError(
                    f"two of the corpora have the {kind} {twice!r}",
                    where=name,
                    fix="rename it in one of them",
                )
        return cls.build(
            name,
            contexts=chain.from_iterable(c.contexts.values() for c in corpora),
            commands=chain.from_iterable(c.commands.values() for c in corpora),
            annotations=chain.from_iterable(c.annotations for c in corpora),
            judgments=chain.from_iterable(c.judgments for c in corpora),
            outcomes=chain.from_iterable(c.outcomes for c in corpora),
            source="; ".join(dict.fromkeys(c.source for c in corpora)),
            licence="; ".join(dict.fromkeys(c.licence for c in corpora)),
        )

    def save(
        self,
        path: Path | str,
        *,
        force: bool = False,
        attachments: Mapping[str, bytes] | None = None,
    ) -> None:
        """Write the corpus: the whole folder or, on any error, nothing.

        Parameters
        ----------
        path
            The folder; its parent must be there.
        force
            Replace the corpus that is there.
        attachments
            Further files by name, such as an import's report.

        Raises
        ------
        FormatError
            If the folder holds something already and `force` isn't given, or holds
            something that is not a corpus.
        """
        files = {**self.files(), **(attachments or {})}
        write_folder(Path(path), files, force=force, marker=MANIFEST)

    @staticmethod
    def check_target(path: Path | str, *, force: bool = False) -> None:
        """Raise the errors of :meth:`save` before any work is done."""
        check_target(Path(path), force=force, marker=MANIFEST)

    def files(self) -> dict[str, bytes]:
        """Return the contents of the files by name, the same for the same corpus."""
        return corpus_tables.files(self.name, self.source, self.licence, self.content)

    @property
    def content(self) -> corpus_tables.Content:
        """The content of the files beside corpus.json."""
        return corpus_tables.Content(
            self.contexts, self.commands, self.annotations, self.judgments, self.outcomes
        )

    @property
    def hash(self) -> str:
        """``sha256:`` and the digest of the content without the subjects.

        It doesn't depend on the salt that hides the subjects, nor on the corpus's name.
        """
        if not self._hash:
            self._hash.append(corpus_tables.content_hash(corpus_tables.encode(self.content)))
        return self._hash[0]

    def filter(self, keep: Callable[[Entry], bool]) -> Corpus:
        """Keep the commands for which a function is true, as :meth:`select` does.

        Examples
        --------
        >>> corpus.filter(lambda entry: len(entry.sdcs) == 1)
        """
        if not callable(keep):
            fix = "give a function of an entry, such as lambda entry: 'truck' in entry.text"
            raise CorpusError(f"keep can't be {keep!r}", fix=fix)
        return self.select(entry.id for entry in self if keep(entry))

    def select(self, ids: Iterable[str]) -> Corpus:
        """Keep some commands, in the given order, with all that belongs to them.

        That is their annotations, outcomes and contexts, and the judgments of their texts with
        their videos. A context that only other commands of the scenario reveal is lost with them.

        Raises
        ------
        CorpusError
            If there is no command with one of the ids.
        """
        chosen = {}
        for id_ in (ids,) if isinstance(ids, str) else ids:
            if id_ not in self.commands:
                raise CorpusError.unknown("command", id_, self.commands, where=self.name)
            chosen[id_] = self.commands[id_]
        kept = [entry for entry in self if entry.id in chosen]
        outcomes = {outcome.id for entry in kept for outcome in entry.outcomes}
        worlds = {entry.context.id for entry in kept if entry.context is not None}
        worlds |= {annotation.context.id for entry in kept for annotation in entry.annotations}
        worlds |= {outcome.context for outcome in self.outcomes if outcome.id in outcomes}
        shown = {(command.text, command.video) for command in chosen.values()}
        return replace(
            self,
            contexts={id_: context for id_, context in self.contexts.items() if id_ in worlds},
            commands=chosen,
            annotations=tuple(a for a in self.annotations if a.command.id in chosen),
            judgments=tuple(j for j in self.judgments if (j.command, j.command_video) in shown),
            outcomes=tuple(outcome for outcome in self.outcomes if outcome.id in outcomes),
        )

    def split(
        self,
        by: Division = "scenario",
        *,
        held_out: Collection[str] | None = None,
        seed: int = 0,
    ) -> tuple[Corpus, Corpus]:
        """Divide the corpus for training and test.

        Parameters
        ----------
        by
            Commands that stay on one side: of a ``scenario``, a ``person`` or a ``world``.
        held_out
            Names of the scenarios, people (their hashes) or worlds to test on; about a third is
            drawn if left out.
        seed
            Random seed of the draw.

        Returns
        -------
        train, test
            As :meth:`select` makes them.

        Raises
        ------
        CorpusError
            If a name is unknown, or a command's person or world is.
        """
        parts = self.parts(by)
        names = sorted(set(parts.values()))
        if held_out is None:
            held_out = draw_parts(names, seed=seed)
        elif isinstance(held_out, str):
            held_out = (held_out,)
        for name in held_out:
            if name not in names:
                raise CorpusError.unknown(by, name, names, where=f"corpus {self.name}")
        tested = set(held_out)
        return (
            self.select(id_ for id_, part in parts.items() if part not in tested),
            self.select(id_ for id_, part in parts.items() if part in tested),
        )

    def parts(self, by: Division) -> dict[str, str]:
        """Return the scenario, person or world of each command, by the command's id.

        Raises
        ------
        CorpusError
            If one is unknown.
        """
        if by not in get_args(Division):
            raise CorpusError.unknown("division", by, get_args(Division))
        if by == "scenario":
            return {id_: command.scenario for id_, command in self.commands.items()}
        if by == "person":
            parts = {id_: command.subject for id_, command in self.commands.items()}
        else:
            parts = contexts_by_command(
                self.commands, self.annotations, self.contexts, self.outcomes
            )
        missing = [id_ for id_ in self.commands if not parts.get(id_)]
        if missing:
            raise CorpusError(
                f"the {by} of {len(missing)} commands is unknown, such as of {missing[0]!r}",
                where=f"corpus {self.name}",
                fix="divide it by scenario",
            )
        return parts

    @property
    def is_authored(self) -> bool:
        """True if all commands were written by authors or by a program, and nobody saw a video."""
        subjects = {command.subject for command in self.commands.values()}
        return bool(subjects) and all(subject.startswith(INVENTED) for subject in subjects)

    def to_pandas(self) -> pd.DataFrame:
        """Make a table with a row for each command."""
        return entries_table(self)

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
            near = nearest(which, self.commands) or list(self.commands)
            raise KeyError(f"there is no command {which!r}; ids are like {next(iter(near), '')!r}")
        if isinstance(which, str):
            return self._all()[list(self.commands).index(self.commands[which].id)]
        return self._all()[which]

    def __contains__(self, which: object) -> bool:
        """Check for a command by its id, or for an entry."""
        return which in self.commands if isinstance(which, str) else which in self._all()

    def _all(self) -> list[Entry]:
        if len(self._entries) != len(self.commands):
            self._entries[:] = entries(
                self.commands, self.annotations, self.contexts, self.outcomes
            )
        return self._entries

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


def draw_parts(names: Iterable[str], *, seed: int) -> tuple[str, ...]:
    """Draw about a third of some names, in their alphabetical order."""
    ordered, rng = sorted(set(names)), np.random.default_rng([seed, _STREAM])
    count = max(1, round(len(ordered) * HELD_OUT))
    return tuple(sorted(rng.choice(ordered, size=count, replace=False).tolist())) if ordered else ()
