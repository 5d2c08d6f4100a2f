"""Putting the AAAI-11 corpus together from its files."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.report import ImportReport, Journal
from corpus_tools.importers.slu_core import slu_files
from corpus_tools.importers.slu_core.slu_files import read_assignments, read_judgments
from corpus_tools.importers.slu_core.slu_trees import read_groundings, read_labels, read_trees
from corpus_tools.importers.slu_core.slu_worlds import Instances
from corpus_tools.runtime.collector_pause import collector_paused
from corpus_tools.runtime.progress import OnProgress, no_progress
from g3.annotation import Annotation, Command, Judgment, Source
from g3.errors import FormatError
from g3.groundings import Context

NAME = "aaai11"

FILES: dict[Source, str] = {
    "positive": slu_files.POSITIVES,
    "random": slu_files.NEGATIVES,
    "easy": slu_files.EASY_NEGATIVES,
}
READERS = 2
"""Number of files that are read at a time."""
UNSAID: dict[Source, bool | None] = {"positive": True, "random": False, "easy": None}
"""Meaning of a missing label of a grounded clause in each file."""


@collector_paused()
def import_slu_core(
    path: Path,
    *,
    salt: str,
    keep_going: bool = False,
    on_progress: OnProgress = no_progress,
) -> tuple[Corpus, ImportReport]:
    """Read the AAAI-11 corpus from a clone of h2r/slu_core, or its data folder.

    See :class:`corpus_tools.importers.importer_registry.ImportFunction`. FormatError if the corpus
    isn't there, or something in it can't be read.
    """
    layout = slu_files.find_layout(path)
    journal = Journal(keep_going)
    progress = _progress(on_progress, len(layout.scenarios) + len(FILES))
    desk = _Desk(journal)
    judgments: list[Judgment] = []
    annotations: list[Annotation] = []
    with ThreadPoolExecutor(READERS) as pool:
        # Unpacking, and most of parsing, need no lock of Python's.
        ahead = {
            name: pool.submit(slu_files.load_records, layout.data, name) for name in FILES.values()
        }
        for scenario in layout.scenarios:
            next(progress)
            desk.typed.update(read_assignments(layout, scenario, salt, journal))
            judgments += read_judgments(layout, scenario, salt, journal)
        for source, name in FILES.items():
            next(progress)
            file, records = slu_files.read_records(layout, name, journal, ahead.pop(name))
            annotations += desk.read_annotations(records, source, file)
    next(progress, None)
    journal.check()
    if not annotations:
        first = f"; the first problem is {journal.skipped[0].error()}" if journal.skipped else ""
        raise FormatError(
            f"there is not a single annotation to import{first}",
            where=str(path),
            fix="fetch the files again",
        )
    corpus = Corpus.build(
        NAME,
        contexts=desk.worlds.contexts(),
        commands=desk.all_commands(),
        annotations=annotations,
        judgments=judgments,
        source=slu_files.SOURCE,
        licence=slu_files.LICENCE,
    )
    return corpus, journal.report(slu_files.IMPORTER, _counts(corpus), _not_imported(layout))


def _progress(on_progress: OnProgress, total: int) -> Iterator[None]:
    for done in range(total + 1):
        on_progress("reading", done, total)
        yield


@dataclass(slots=True)
class _Desk:
    """Records read so far, for those that refer to them."""

    journal: Journal
    worlds: Instances = field(default_factory=Instances)
    typed: dict[str, Command] = field(default_factory=dict)
    """By assignment."""
    annotated: dict[str, Command] = field(default_factory=dict)
    """By id: the commands with the texts that were annotated."""
    positives: dict[str, Annotation] = field(default_factory=dict)
    """By assignment, as the annotation files name it."""

    def all_commands(self) -> list[Command]:
        """Every command once, by scenario and number."""
        typed = {command.id: command for command in self.typed.values()}
        return sorted((typed | self.annotated).values(), key=lambda command: command.id)

    def read_annotations(
        self, records: Iterable[Any], source: Source, file: str
    ) -> Iterator[Annotation]:
        """Yield the annotations of one file; unreadable ones go to the journal."""
        times: dict[str, int] = defaultdict(int)
        for number, record in enumerate(records, start=1):
            assignment = record.get("assignmentId") if isinstance(record, dict) else None
            try:
                if assignment is None:
                    raise FormatError("this record has no assignmentId", fix="add it")
                annotation = self._read_annotation(record, str(assignment), source)
            except FormatError as error:
                self.journal.skip(file, f"record {number} ({assignment})", error)
                continue
            name = f"{annotation.command.id}/{source}"
            times[name] += 1
            if times[name] > 1:
                name = f"{name}-{times[name]}"
            yield replace(annotation, id=name)

    def _read_annotation(self, record: Any, assignment: str, source: Source) -> Annotation:
        match record.get("command"):
            case [str(text), trees]:
                pass
            case _:
                raise FormatError(
                    "the command is not [text, [SDC, ...]]", where="command", fix="correct it"
                )
        typed = self.typed.get(_base(assignment))
        if typed is None:
            raise FormatError(
                "no scenario's assignments hold this assignment",
                where="assignmentId",
                fix="restore the scenario's assignments.yaml",
            )
        sdcs = read_trees(trees, text)
        context = self._context(record, assignment, typed, source)
        restored = self.worlds.headings_restored
        groundings = read_groundings(
            record, sdcs, lambda value, where: self.worlds.read_grounding(value, context, where)
        )
        annotation = Annotation(
            id="",
            command=self._command(typed, assignment, text),
            context=context,
            sdcs=sdcs,
            groundings=groundings,
            correct=read_labels(record, groundings, UNSAID[source]),
            source=source,
        )
        if source == "positive":
            self.positives.setdefault(assignment, annotation)
        elif sdcs != self.positives[assignment].sdcs:
            self.journal.note(
                f"the SDC trees of the {source} negative differ from the positive's",
                annotation.command.id,
            )
        if self.worlds.headings_restored > restored:
            self.journal.note(
                f"headings of objects of the {source} negative, which are in no context and "
                "were not published, are taken from their footprints",
                annotation.command.id,
            )
        return annotation

    def _context(self, record: Any, assignment: str, typed: Command, source: Source) -> Context:
        if source == "positive":
            return self.worlds.read_context(
                record.get("context"), record.get("agent"), typed.scenario
            )
        positive = self.positives.get(assignment)
        if positive is None:
            raise FormatError(
                "no positive record, whose context is needed, has this assignment",
                where="assignmentId",
                fix=f"restore the record in {slu_files.POSITIVES}",
            )
        return positive.context

    def _command(self, typed: Command, assignment: str, text: str) -> Command:
        """Return the command with the text that was annotated, which its words refer to."""
        first = typed.id + assignment[len(_base(assignment)) :]
        name, number = first, 1
        while name in self.annotated and self.annotated[name].text != text:
            number += 1
            name = f"{first}/{number}"
        if name not in self.annotated:
            self._note_text(name, typed, text, another=number > 1)
            self.annotated[name] = replace(typed, id=name, text=text)
        return self.annotated[name]

    def _note_text(self, name: str, typed: Command, text: str, *, another: bool) -> None:
        if another:
            self.journal.note("annotated in a second wording", name)
        elif name != typed.id:
            self.journal.note("annotated in parts", name)
        elif typed.text.split() != text.split():
            self.journal.note("the annotated text differs from what was typed", name)
        elif typed.text != text:
            self.journal.note(
                "the annotated text differs from what was typed in white space only", name
            )


def _base(assignment: str) -> str:
    """Return the assignment itself, without the number of a part of its command."""
    return assignment.partition("_")[0]


def _counts(corpus: Corpus) -> dict[str, int]:
    by_source = Counter(annotation.source for annotation in corpus.annotations)
    by_study = Counter(judgment.study for judgment in corpus.judgments)
    return {
        "scenarios": len({command.scenario for command in corpus.commands.values()}),
        "contexts": len(corpus.contexts),
        "commands typed": len(corpus.commands),
        **{f"annotations, {source}": by_source[source] for source in FILES},
        **{f"judgments, {study}": count for study, count in sorted(by_study.items())},
    }


def _not_imported(layout: slu_files.Layout) -> dict[str, int]:
    folders = [layout.data / slu_files.SCENARIOS / scenario for scenario in layout.scenarios]
    return {
        name: sum((folder / name).is_file() for folder in folders)
        for name in slu_files.NOT_IMPORTED
    }
