"""The AAAI-11 corpus, put together from its files, and the other parts of the authors' release."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args

import msgspec

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.start_headings import parse_heading
from corpus_tools.importers.report import ImportReport, Journal
from corpus_tools.importers.slu_core import slu_files
from corpus_tools.importers.slu_core.automatic_corpus import (
    OBJECTS,
    STATUS,
    WorldFolders,
    import_automatic,
)
from corpus_tools.importers.slu_core.slu_files import (
    COMPRESSED,
    IMPORTER,
    SCENARIOS,
    find_layout,
    read_assignments,
    read_judgments,
)
from corpus_tools.importers.slu_core.slu_trees import read_groundings, read_labels, read_trees
from corpus_tools.importers.slu_core.slu_worlds import Instances
from corpus_tools.importers.slu_core.spatial_relations import RelationFiles, import_relations
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


Part: TypeAlias = Literal["aaai11", "automatic", "spatial-relations"]
PARTS: tuple[Part, ...] = get_args(Part)
ALL = "all"
AUTOMATIC = "automatic"
"""Part of the names of folders with random tasks."""
RELATIONS, RELATION_FILES = "spatial_relations", "spatialRelations*.yaml"
"""The folder of phrases of paths; how its files are called where they lie elsewhere."""


def import_parts(
    path: Path,
    *,
    salt: str,
    keep_going: bool = False,
    on_progress: OnProgress = no_progress,
    part: str = "aaai11",
    heading: str = "loads",
) -> tuple[Corpus, ImportReport]:
    """Import a part of the release, or all of it that is there as one corpus.

    See :class:`corpus_tools.importers.importer_registry.ImportFunction`. `path` is a clone of
    h2r/slu_core, its data folder, or a folder with some of the parts; `part` one of `PARTS`, or
    `ALL`; `heading` which way the robot of random tasks faces
    (:func:`corpus_tools.corpus.start_headings.parse_heading`). FormatError if the part isn't there,
    or something in it can't be read.
    """
    rule = parse_heading(heading)
    worlds, relations = find_automatic(path), find_relations(path)
    importers: Mapping[Part, Callable[[], tuple[Corpus, ImportReport]]] = {
        "aaai11": lambda: import_slu_core(
            path, salt=salt, keep_going=keep_going, on_progress=on_progress
        ),
        "automatic": lambda: import_automatic(
            worlds, salt=salt, heading=rule, keep_going=keep_going, on_progress=on_progress
        ),
        "spatial-relations": lambda: import_relations(
            relations, keep_going=keep_going, on_progress=on_progress
        ),
    }
    there = tuple(_parts_there(path, worlds, relations))
    taken = there if part == ALL else (part,)
    if part not in there and there and part != ALL:
        raise FormatError(
            f"the part {part} is not there; {', '.join(there)} is",
            where=str(path),
            fix=f"import it with --part {there[0]}, or give a clone of h2r/slu_core",
        )
    if not there:
        find_layout(path)  # tells what is looked for
    done = [importers[name]() for name in PARTS if name in taken]
    reports = [report for _, report in done]
    corpus = done[0][0] if len(done) == 1 else Corpus.merge(IMPORTER, [c for c, _ in done])
    return corpus, msgspec.structs.replace(
        _joined(reports), parts_there=there, parts_taken=tuple(p for p in PARTS if p in taken)
    )


def find_automatic(path: Path) -> WorldFolders:
    """Find the folders of random tasks: in a clone, beside each other, or in `path` itself."""
    path = path.resolve()
    for data in (path / SCENARIOS, path / "data" / SCENARIOS, path):
        groups = [folder for folder in _folders(data) if _is_group(folder)]
        worlds = [world for group in groups for world in _folders(group)]
        if worlds:
            base = data if data == path else data.parent
            return WorldFolders(base, tuple(world.relative_to(base).as_posix() for world in worlds))
    worlds = list(_folders(path)) if _is_group(path) else []
    return WorldFolders(path, tuple(world.name for world in worlds))


def find_relations(path: Path) -> RelationFiles:
    """Find the files with phrases of paths: in a clone, or in `path` itself."""
    path = path.resolve()
    for data, pattern in (
        (path, f"{RELATIONS}/*.yaml"),
        (path / "data", f"{RELATIONS}/*.yaml"),
        (path, RELATION_FILES),
    ):
        files = chain(data.glob(pattern), data.glob(pattern + COMPRESSED))
        names = {file.relative_to(data).as_posix().removesuffix(COMPRESSED) for file in files}
        if names:
            return RelationFiles(data, tuple(sorted(names)))
    return RelationFiles(path, ())


def _folders(path: Path) -> Iterator[Path]:
    if path.is_dir():
        yield from sorted(p for p in path.iterdir() if p.is_dir() and not p.name.startswith("."))


def _is_group(folder: Path) -> bool:
    """Check that a folder holds folders of videos, of which at least one is of a random task."""
    inner = list(_folders(folder))
    has_log = any((world / STATUS).is_file() for world in inner)
    has_world = any((world / OBJECTS).is_file() for world in inner)
    return has_log or (has_world and AUTOMATIC in folder.name)


def _parts_there(path: Path, worlds: WorldFolders, relations: RelationFiles) -> Iterator[Part]:
    try:
        find_layout(path)
    except FormatError:
        pass
    else:
        yield "aaai11"
    if worlds.folders:
        yield "automatic"
    if relations.names:
        yield "spatial-relations"


def _joined(reports: list[ImportReport]) -> ImportReport:
    if len(reports) == 1:
        return reports[0]

    def numbers(name: str) -> dict[str, int]:
        joined: dict[str, int] = {}
        for report in reports:
            for key, count in getattr(report, name).items():
                joined[key] = joined.get(key, 0) + count
        return joined

    return ImportReport(
        importer=IMPORTER,
        counts=numbers("counts"),
        skipped=tuple(chain.from_iterable(r.skipped for r in reports)),
        notes=tuple(chain.from_iterable(r.notes for r in reports)),
        not_imported=numbers("not_imported"),
        missing=tuple(chain.from_iterable(r.missing for r in reports)),
        files=tuple(chain.from_iterable(r.files for r in reports)),
    )
