"""Putting an authored corpus together from its files."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.authored import authored_files
from corpus_tools.importers.authored.authored_clauses import (
    Clauses,
    Groundings,
    check_clauses,
    check_log,
    generator,
    random_groundings,
    read_clauses,
    relabel,
)
from corpus_tools.importers.authored.authored_files import World, read_world
from corpus_tools.importers.report import ImportReport, Journal
from corpus_tools.runtime.progress import OnProgress, no_progress
from corpus_tools.world.scenarios.documents import Document, read_document
from corpus_tools.world.scenarios.scenario_files import SCENARIOS
from corpus_tools.world.scenarios.scenario_reading import first_error, scenario_files, scenario_of
from g3.annotation import Annotation, Command, Source
from g3.errors import FormatError
from g3.sdc.clauses import SDC_TYPES, breadth_first

IMPORTER = "authored"
LOG_INTERVAL_S = 10_000.0
"""From the start of one scenario's log to that of the next."""


@dataclass(frozen=True, slots=True)
class _Grounded:
    """A command with its right groundings, and where it was given."""

    command: Command
    clauses: Clauses
    world: World


def import_authored(
    path: Path,
    *,
    salt: str = "",
    keep_going: bool = False,
    on_progress: OnProgress = no_progress,
) -> tuple[Corpus, ImportReport]:
    """Read an authored corpus: a folder with dataset.yaml, scenarios, layouts and logs.

    See :class:`corpus_tools.importers.importer_registry.ImportFunction`; datasets/warehouse is such
    a folder. FormatError if the corpus isn't there, or something in it can't be read.
    """
    journal = Journal(keep_going)
    dataset = authored_files.read_dataset(path, journal)
    files = list(scenario_files(path).values())
    grounded: list[_Grounded] = []
    worlds: list[World] = []
    for number, file in enumerate(files, start=1):
        on_progress("reading", number - 1, len(files))
        name = f"{SCENARIOS}/{file.name}"
        try:
            document = read_document(file, name)
            commands = authored_files.commands_of(document)
            authored_files.note_file(name, document.content, len(commands), journal)
            scenario = first_error(*scenario_of(document, file))
            world = read_world(path, scenario, number * LOG_INTERVAL_S, journal)
            check_log(world)
        except FormatError as error:
            place, _, field = error.where.partition(": ")
            journal.skip(place, "", FormatError(error.what, where=field, fix=error.fix))
            continue
        worlds.append(world)
        grounded += _read_commands(document, len(commands), world, dataset, journal)
    journal.check()
    if not grounded:
        raise FormatError(
            f"there is no command in {SCENARIOS}/*.yaml",
            where=str(path),
            fix="docs/authored-corpora.md describes the files",
        )
    corpus = Corpus.build(
        dataset.name,
        contexts=[world.context for world in worlds],
        commands=[item.command for item in grounded],
        annotations=[
            annotation for item in grounded for annotation in _annotations(item, worlds, dataset)
        ],
        source=f"{dataset.source} Seed of the random negatives: {dataset.seed}.",
        licence=dataset.licence,
    )
    return corpus, journal.report(IMPORTER, _counts(corpus, grounded), {})


def _read_commands(
    document: Document, count: int, world: World, dataset: authored_files.Dataset, journal: Journal
) -> list[_Grounded]:
    scenario = world.scenario
    found: list[_Grounded] = []
    for i in range(count):
        try:
            utterance = authored_files.read_utterance(document, i)
            clauses = read_clauses(utterance, world, dataset)
            check_clauses(clauses, world)
        except FormatError as error:
            line, _ = document.marks["commands", i]
            journal.skip(f"{document.name}:{line}", _title(document, i), error)
            continue
        command = Command(
            id=f"{scenario.id}-{i + 1:02}",
            text=utterance.text,
            scenario=scenario.id,
            video=scenario.id,
            subject=utterance.subject,
        )
        found.append(_Grounded(command, clauses, world))
    return found


def _title(document: Document, i: int) -> str:
    command = document.value["commands"][i]
    text = command.get("text") if isinstance(command, dict) else None
    return f"command {i + 1} ({text!r})"


def _annotations(
    item: _Grounded, worlds: Sequence[World], dataset: authored_files.Dataset
) -> tuple[Annotation, Annotation]:
    """Make the positive and the random negative annotation."""
    clauses = item.clauses
    drawn = random_groundings(clauses, item.world, worlds, generator(dataset.seed, item.command.id))
    right = tuple(True if groundings else None for groundings in clauses.groundings)

    def annotation(
        source: Source, groundings: tuple[Groundings, ...], correct: tuple[bool | None, ...]
    ) -> Annotation:
        name, context = f"{item.command.id}/{source}", item.world.context
        return Annotation(name, item.command, context, clauses.sdcs, groundings, correct, source)

    return (
        annotation("positive", clauses.groundings, right),
        annotation("random", drawn, relabel(clauses, drawn, dataset)),
    )


def _counts(corpus: Corpus, grounded: Sequence[_Grounded]) -> dict[str, int]:
    types = Counter(sdc.type for item in grounded for sdc in breadth_first(item.clauses.sdcs))
    return {
        "scenarios": len(corpus.contexts),
        "commands": len(corpus.commands),
        **{f"{name} clauses": types[name] for name in SDC_TYPES},
        "annotations": len(corpus.annotations),
    }
