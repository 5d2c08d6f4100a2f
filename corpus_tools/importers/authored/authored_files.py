"""Records in the files of an authored corpus, the logs of its scenarios, and reading them.

Scenarios are read by :mod:`corpus_tools.world.scenarios`.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from corpus_tools.importers.report import Journal, SourceFile
from corpus_tools.runtime.shipped import DATASET
from corpus_tools.world.scenarios import documents
from corpus_tools.world.scenarios.contexts import scenario_places
from corpus_tools.world.scenarios.scenario import ROBOT, Scenario
from corpus_tools.world.scenarios.scenario_files import Utterance
from corpus_tools.world.scenarios.scenario_logs import log_file, scenario_log
from corpus_tools.world.state.recording import to_context
from corpus_tools.world.state.robot_script import DRIVE_TO
from g3.actions.forklift_actions import PICK_UP, PUT_DOWN, WAIT
from g3.errors import FormatError
from g3.groundings import Context, PhysicalObject, Place
from g3.short_repr import short_repr
from g3.storage import regular_file

MANUAL = "docs/authored-corpora.md"

T = TypeVar("T")


class _DatasetFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    name: str
    source: str
    licence: str
    seed: int
    words: dict[str, Any]


@short_repr
@dataclass(frozen=True, slots=True)
class Dataset:
    """The file dataset.yaml: the settings that all scenarios share."""

    name: str
    source: str
    licence: str
    seed: int
    """Seed of the random negatives."""
    words: Mapping[str, tuple[str, ...]]
    """For each word of leaf OBJECTs the labels of which an object must have at least one; no labels
    mean that any object fits."""


def read_dataset(folder: Path, journal: Journal) -> Dataset:
    """Read dataset.yaml; FormatError if it isn't there or can't be read."""
    path = folder / DATASET
    if not path.is_file():
        raise FormatError(
            f"this is not an authored corpus: it has no {DATASET}",
            where=str(folder),
            fix="docs/authored-corpora.md says what the folder holds",
        )
    document = documents.read_document(path)
    note_file(DATASET, document.content, 0, journal)
    shared = _part(document, (), _DatasetFile)
    words = {word: _part(document, ("words", word), tuple[str, ...]) for word in shared.words}
    return Dataset(shared.name, shared.source, shared.licence, shared.seed, words)


def note_file(name: str, content: bytes, records: int, journal: Journal) -> None:
    """Note that a file was read."""
    journal.files.append(SourceFile(name, hashlib.sha256(content).hexdigest(), records))


def commands_of(document: documents.Document) -> list[Any]:
    """Return the commands of a scenario's file as written; FormatError if they are no list."""
    if not isinstance(document.value, dict) or "commands" not in document.value:
        return []
    return _part(document, ("commands",), list[Any])


def read_utterance(document: documents.Document, number: int) -> Utterance:
    """Read the command with an index in a scenario's file.

    One of another form is a FormatError whose ``where`` is the field in it.
    """
    field = ("commands", number)
    found = documents.convert(document.value["commands"][number], Utterance, field, MANUAL)
    if isinstance(found, documents.Problem):
        raise FormatError(
            found.what, where=documents.field_name(found.field[len(field) :]), fix=found.fix
        )
    return found


def _part(document: documents.Document, field: documents.Field, record_type: type[T]) -> T:
    """Convert a part of a document to a record; FormatError with its line if it is invalid."""
    value = document.value
    for key in field:
        value = value[key]
    found = documents.convert(value, record_type, field, MANUAL)
    if isinstance(found, documents.Problem):
        raise document.error(found)
    return found


@short_repr
@dataclass(frozen=True, slots=True)
class World:
    """A scenario's context with its log."""

    scenario: Scenario
    context: Context
    """Agent and objects have their trajectories in the log."""
    places: dict[str, Place]
    moved: PhysicalObject | None
    """The object that the robot last picks up or puts down, if any."""

    @property
    def objects(self) -> dict[str, PhysicalObject]:
        """The context's objects by id, the robot among them."""
        return {item.id: item for item in self.context.objects}


def read_world(folder: Path, scenario: Scenario, start_s: float, journal: Journal) -> World:
    """Read a scenario's log, which starts at `start_s` on the corpus's clock.

    Logs of different scenarios must not overlap in time: whether two things moved together is seen
    from their clocks. FormatError if there is no log, or it shows an earlier version of the
    scenario.
    """
    log = scenario_log(scenario, folder)
    path = log_file(scenario, folder)
    name = path.relative_to(folder).as_posix()
    note_file(name, regular_file.read_bytes(path), len(log.recording.t_ns), journal)
    context = to_context(log.recording, start_s)
    moved = _moved(scenario)
    return World(
        scenario,
        context,
        scenario_places(scenario),
        next((item for item in context.objects if item.id == moved), None),
    )


def ends(scenario: Scenario) -> dict[str, str]:
    """Return the final place of each thing that the script brings to one, by the thing."""
    held = scenario.robot.carries
    found: dict[str, str] = {}
    for step in scenario.script:
        argument = str(step.argument)
        if step.kind is PICK_UP:
            held = argument
            found.pop(held, None)
        elif step.kind is PUT_DOWN and held is not None:
            found[held] = argument
            held = None
        if step.action == DRIVE_TO.name:
            found[ROBOT] = argument
        elif step.kind is not WAIT:
            found.pop(ROBOT, None)
    return found


def _moved(scenario: Scenario) -> str | None:
    held, moved = scenario.robot.carries, None
    for step in scenario.script:
        if step.kind is PICK_UP:
            held = moved = str(step.argument)
        elif step.kind is PUT_DOWN:
            moved = held
    return moved
