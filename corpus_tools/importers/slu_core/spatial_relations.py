"""Phrases of paths ("away from the desk"), each with an indoor path and a landmark.

An example says whether the phrase fits the path. Nobody typed the phrases: they are a relation
and a landmark's name. The same phrase is one command with many annotations, so that divisions
keep its examples on one side.
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.report import ImportReport, Journal
from corpus_tools.importers.slu_core import slu_files
from corpus_tools.importers.slu_core.slu_trees import read_groundings, read_labels, read_trees
from corpus_tools.importers.slu_core.slu_worlds import MICROSECONDS, Instances
from corpus_tools.runtime.progress import OnProgress, no_progress
from g3.annotation import Annotation, Command
from g3.errors import FormatError
from g3.groundings import Context, Grounding, PhysicalObject, Prism, Trajectory
from g3.groundings import Path as PathGrounding
from g3.short_repr import short_repr

NAME = "spatial-relations"
POINT_M = 0.1
"""Edge of the square that stands for a landmark of which only a point is known. Those who walk
have such a square too."""
SMALLEST_M = 0.01
"""Landmarks that are smaller are points."""


@short_repr
@dataclass(frozen=True, slots=True)
class RelationFiles:
    """Files of the examples, without the ending of compressed ones, relative to `data`."""

    data: Path
    names: tuple[str, ...]


def import_relations(
    found: RelationFiles,
    *,
    keep_going: bool = False,
    on_progress: OnProgress = no_progress,
) -> tuple[Corpus, ImportReport]:
    """Read the examples; FormatError if something can't be read.

    A scenario is a landmark's name, such as ``spatial-relations/desk``, so that divisions by
    scenarios test on landmarks that were not trained on. A phrase that fits its path is a positive
    annotation, another one a random negative.
    """
    journal = Journal(keep_going)
    shelf = _Shelf()
    annotations: list[Annotation] = []
    for done, name in enumerate(found.names):
        on_progress("reading", done, len(found.names))
        file, records = slu_files.read_records(slu_files.Layout(found.data, ()), name, journal)
        for number, record in enumerate(records, start=1):
            try:
                annotations.append(shelf.read(record))
            except FormatError as error:
                told = record.get("assignmentId") if isinstance(record, dict) else None
                journal.skip(file, f"record {number} ({told})", error)
    journal.check()
    for landmark, count in sorted(shelf.points.items()):
        journal.note(
            f"only a point is known of a landmark; it is a square of {POINT_M:g} m",
            f"{landmark} ({count})",
        )
    corpus = Corpus.build(
        NAME,
        contexts=shelf.contexts.values(),
        commands=sorted(shelf.commands.values(), key=lambda command: command.id),
        annotations=annotations,
        source=f"{slu_files.SOURCE}; times of paths, and sizes of landmarks that are points, are "
        "assumed",
        licence=slu_files.LICENCE,
    )
    return corpus, journal.report(slu_files.IMPORTER, _counts(corpus), {})


def _counts(corpus: Corpus) -> dict[str, int]:
    sources = Counter(annotation.source for annotation in corpus.annotations)
    return {
        "phrases of paths": len(corpus.commands),
        "paths with landmarks": len(corpus.contexts),
        "examples that are right": sources["positive"],
        "examples that are wrong": sources["random"],
    }


@dataclass(slots=True)
class _Shelf:
    """Things read so far, each once."""

    instances: Instances = field(default_factory=Instances)
    contexts: dict[tuple[int, ...], Context] = field(default_factory=dict)
    """By the instances in them."""
    commands: dict[str, Command] = field(default_factory=dict)
    """By text."""
    points: Counter[str] = field(default_factory=Counter)
    """Number of landmarks of each label that are points."""
    _assumed: set[str] = field(default_factory=set)
    """Ids of landmarks whose size is assumed."""
    _landmarks: dict[int, PhysicalObject] = field(default_factory=dict)
    _walkers: dict[int, PhysicalObject] = field(default_factory=dict)
    _paths: dict[int, PathGrounding] = field(default_factory=dict)
    _numbers: Counter[str] = field(default_factory=Counter)
    _times: Counter[str] = field(default_factory=Counter)

    def read(self, record: Any) -> Annotation:
        """Read an example."""
        match record:
            case {"command": [str(text), trees], "agent": agent}:
                pass
            case _:
                raise FormatError(
                    "this is not an example",
                    fix="it needs command: [text, [SDC, ...]], agent, objectGroundings and "
                    "groundingIsCorrect",
                )
        sdcs = read_trees(trees, text)
        groundings = read_groundings(record, sdcs, self._grounding)
        labels = read_labels(record, groundings, None)
        walker = self._walker(agent)
        landmarks = [g for group in groundings for g in group if isinstance(g, PhysicalObject)]
        name = " ".join(landmarks[0].labels) if landmarks else "nothing"
        command = self._command(text, f"{NAME}/{name}")
        is_right = False not in labels
        return Annotation(
            id=self._annotation_id(command, record.get("assignmentId")),
            command=command,
            context=self._context(walker, landmarks, command.scenario),
            sdcs=sdcs,
            groundings=groundings,
            correct=labels,
            source="positive" if is_right else "random",
        )

    def _command(self, text: str, scenario: str) -> Command:
        slug = re.sub(r"\W+", "-", text).strip("-") or "phrase"
        name = f"{NAME}/{slug}"
        if text not in self.commands:
            taken = {command.id for command in self.commands.values()}
            while name in taken:
                name += "-2"
            self.commands[text] = Command(name, text, scenario)
        return self.commands[text]

    def _annotation_id(self, command: Command, assignment: object) -> str:
        number = str(assignment or "").rpartition("_")[2] or "example"
        name = f"{command.id}/{number}"
        self._times[name] += 1
        return name if self._times[name] == 1 else f"{name}-{self._times[name]}"

    def _context(
        self, walker: PhysicalObject, landmarks: list[PhysicalObject], scenario: str
    ) -> Context:
        things = tuple(dict.fromkeys(landmarks))
        key = (id(walker), *map(id, things))
        if key not in self.contexts:
            self._numbers[scenario] += 1
            self.contexts[key] = Context(
                f"{scenario}/{self._numbers[scenario]}",
                (*things, walker),
                (),
                walker.id,
                tuple((item.id, "size") for item in things if item.id in self._assumed),
            )
        return self.contexts[key]

    def _walker(self, value: Any) -> PhysicalObject:
        read = self.instances.read_object(value, "agent")
        if id(read) not in self._walkers:
            trajectory = self._path(read.trajectory).trajectory
            self._walkers[id(read)] = replace(read, trajectory=trajectory)
        return self._walkers[id(read)]

    def _path(self, trajectory: Trajectory) -> PathGrounding:
        """Read a path of numbered poses: the numbers become seconds."""
        if id(trajectory) not in self._paths:
            t = trajectory.t * MICROSECONDS
            self._paths[id(trajectory)] = PathGrounding(
                Trajectory(t, trajectory.xyz, trajectory.yaw)
            )
        return self._paths[id(trajectory)]

    def _grounding(self, value: Any, where: str) -> Grounding:
        match value:
            case ["PhysicalObject", {**fields}]:
                # Landmarks have no ids in the file.
                return self._landmark(self.instances.read_object({**fields, "lcmId": ""}, where))
        read = self.instances.read_grounding(value, _NOWHERE, where)
        return self._path(read.trajectory) if isinstance(read, PathGrounding) else read

    def _landmark(self, read: PhysicalObject) -> PhysicalObject:
        """Read a landmark with an id, and with an extent."""
        key = id(read)
        if key not in self._landmarks:
            label = "-".join(read.labels) or "landmark"
            self._numbers[label] += 1
            name = f"{label}-{self._numbers[label]}"
            prism = read.prism
            if np.ptp(prism.xy, axis=0).max() < SMALLEST_M:
                self.points[label] += 1
                self._assumed.add(name)
                prism = _square(prism)
            self._landmarks[key] = replace(read, id=name, prism=prism)
        return self._landmarks[key]


_NOWHERE = Context("", (), (), "")


def _square(prism: Prism) -> Prism:
    half = POINT_M / 2
    corners = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
    return Prism(prism.xy.mean(axis=0) + corners, prism.z_min, prism.z_max)
