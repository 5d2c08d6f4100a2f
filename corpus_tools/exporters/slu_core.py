"""A corpus in the layout of slu_core, the authors' release of the AAAI-11 corpus.

``ct import slu-core`` reads it again. What that layout has no room for is left out: names of
places, hard negatives, outcomes, and groundings without a label (a missing label has a meaning
there).
"""

from __future__ import annotations

import bz2
import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

import msgspec
import numpy as np

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.slu_core import slu_files
from g3.annotation import Annotation, Judgment, Source
from g3.groundings import (
    Context,
    FloatArray,
    Grounding,
    PhysicalObject,
    Place,
    Prism,
    Trajectory,
)
from g3.sdc.clauses import CHILD_FIELDS, SDC, Span, breadth_first, child_indices
from g3.sdc.sdc_notation import has_implicit_figure

DATA = "data"
MARKER = f"{DATA}/{slu_files.POSITIVES}{slu_files.COMPRESSED}"
FILES: dict[Source, str] = {
    "positive": slu_files.POSITIVES,
    "random": slu_files.NEGATIVES,
    "easy": slu_files.EASY_NEGATIVES,
}
MICROSECONDS = 1e6
NOWHERE = Context("", (), (), "")
T = TypeVar("T")
_NOT_IN_NAMES = re.compile(r"[^\w.-]+")


def slu_core_files(corpus: Corpus) -> dict[str, bytes]:
    """Return the files' contents by name."""
    names = {command: f"A{n:05d}" for n, command in enumerate(corpus.commands, start=1)}
    writer = _Writer()
    files = {}
    for source, name in FILES.items():
        records = (
            writer.record(annotation, names[annotation.command.id])
            for annotation in corpus.annotations
            if annotation.source == source
        )
        files[f"{DATA}/{name}{slu_files.COMPRESSED}"] = bz2.compress(_yaml(records))
    typed: dict[str, list[Any]] = defaultdict(list)
    for command in corpus.commands.values():
        typed[_folder(command.scenario)].append(
            {
                "assignmentId": names[command.id],
                "command": command.text,
                "workerId": command.subject,
                "youtubeId": command.video,
            }
        )
    judged = _judgments(corpus)
    for scenario in sorted({*typed, *judged}):
        folder = f"{DATA}/{slu_files.SCENARIOS}/{scenario}"
        files[f"{folder}/{slu_files.ASSIGNMENTS}"] = _yaml(typed.get(scenario, []))
        files[f"{folder}/{slu_files.EVALUATIONS[0]}"] = _yaml(judged.get(scenario, []))
    return files


def _judgments(corpus: Corpus) -> Mapping[str, list[Any]]:
    """Return the judgments by the folder of the scenario for which the command was typed."""
    scenarios: dict[object, str] = {}
    for command in corpus.commands.values():
        scenarios.setdefault((command.text, command.video), command.scenario)
        scenarios.setdefault(command.video, command.scenario)
    found: dict[str, list[Any]] = defaultdict(list)
    for judgment in corpus.judgments:
        video = judgment.command_video
        scenario = scenarios.get((judgment.command, video)) or scenarios.get(video, video)
        found[_folder(scenario)].append(_evaluation(judgment))
    return found


def _evaluation(judgment: Judgment) -> dict[str, str]:
    return {
        "assignmentId": judgment.id,
        "command": judgment.command,
        "commandYoutubeId": judgment.command_video,
        "displayedYoutubeId": judgment.shown_video,
        "similarityScore": judgment.rating,
        "workerId": judgment.subject,
    }


@dataclass(frozen=True, slots=True)
class _Clause:
    """A clause as it is written, and where it stood in the annotation if it did."""

    value: dict[str, Any]
    index: int | None
    children: tuple[_Clause, ...] = ()


def _clauses(sdcs: Sequence[SDC]) -> list[_Clause]:
    nodes = list(breadth_first(sdcs))
    below = child_indices(sdcs)

    def read(index: int) -> _Clause:
        sdc = nodes[index]
        fields: dict[str, Any] = {}
        if sdc.relation:
            fields["r"] = _words(sdc.relation)
        if sdc.words:
            fields["f"] = _words(sdc.words)
        children: list[_Clause] = []
        if sdc.type == "EVENT" and not sdc.figure:  # whoever reads it makes one
            children.append(_Clause({}, None))
        for name in CHILD_FIELDS:
            inner = [read(i) for i in below[index].get(name, ())]
            children += inner
            if inner and not (name == "f" and has_implicit_figure(sdc)):
                fields[name] = [clause.value for clause in inner]
        return _Clause({sdc.type: fields}, index, tuple(children))

    return [read(i) for i in range(len(sdcs))]


def _words(spans: Sequence[Span]) -> list[Any]:
    return [[span.text, [span.start, span.end]] for span in spans]


@dataclass(slots=True)
class _Writer:
    """Writer of records; shared parts are put into text once."""

    _written: dict[int, tuple[object, msgspec.Raw]] = field(default_factory=dict)

    def record(self, annotation: Annotation, assignment: str) -> dict[str, Any]:
        tops = _clauses(annotation.sdcs)
        level, clauses = list(tops), []
        while level:
            clauses += level
            level = [child for clause in level for child in clause.children]
        labels = [None if c.index is None else annotation.correct[c.index] for c in clauses]
        groundings = [
            [self._grounding(g) for g in annotation.groundings[clause.index]]
            if clause.index is not None and (label is not None or annotation.source == "easy")
            else []
            for clause, label in zip(clauses, labels, strict=True)
        ]
        # As in the release, only the positives say what is in the world.
        world = annotation.context if annotation.source == "positive" else NOWHERE
        return {
            "assignmentId": assignment,
            "command": [annotation.command.text, [clause.value for clause in tops]],
            "agent": self._object(annotation.context.agent),
            "context": self._context(world),
            "source": [None] * len(clauses),
            "objectGroundings": groundings,
            "groundingIsCorrect": labels,
        }

    def _grounding(self, grounding: Grounding) -> list[Any]:
        if isinstance(grounding, PhysicalObject):
            return ["PhysicalObject", self._object(grounding)]
        if isinstance(grounding, Place):
            return ["Place", _place(grounding)]
        return ["Path", self._once(grounding.trajectory, _path)]

    def _object(self, item: PhysicalObject) -> msgspec.Raw:
        return self._once(item, _object)

    def _context(self, context: Context) -> msgspec.Raw:
        return self._once(context, self._whole_context)

    def _whole_context(self, context: Context) -> dict[str, Any]:
        return {
            "objects": [["PhysicalObject", self._object(item)] for item in context.objects],
            "places": [["Place", _place(place)] for place in context.places],
        }

    def _once(self, thing: T, write: Callable[[T], dict[str, Any]]) -> msgspec.Raw:
        # The thing is kept too, so that no other one gets its id.
        if id(thing) not in self._written:
            self._written[id(thing)] = (thing, msgspec.Raw(msgspec.json.encode(write(thing))))
        return self._written[id(thing)][1]


def _object(item: PhysicalObject) -> dict[str, Any]:
    return {
        "lcmId": item.id,
        "tag": item.labels,
        "prism": _prism(item.prism),
        "path": _path(item.trajectory),
    }


def _place(place: Place) -> dict[str, Any]:
    return {"prism": _prism(place.prism)}


def _path(path: Trajectory) -> dict[str, Any]:
    return {
        "points_xyztheta": _rows(np.column_stack([path.xyz, path.yaw])),
        "timestamps": [str(round(t * MICROSECONDS)) for t in path.t.tolist()],
    }


def _prism(prism: Prism) -> dict[str, Any]:
    (heights,) = np.array([[prism.z_min, prism.z_max]]).tolist()
    return {
        "points": _rows(prism.xy),
        "zStart": _number(heights[0]),
        "zEnd": _number(heights[1]),
    }


def _rows(values: FloatArray) -> list[list[msgspec.Raw]]:
    return [[_number(value) for value in row] for row in values.tolist()]


def _number(value: float) -> msgspec.Raw:
    # YAML 1.1 takes 1e-05 for a word.
    text = repr(value)
    return msgspec.Raw((text if "e" not in text else f"{value:.20f}").encode())


def _folder(scenario: str) -> str:
    return _NOT_IN_NAMES.sub("-", scenario).strip(".") or "scenario"


def _yaml(records: Iterable[Any]) -> bytes:
    """Format a list in YAML's flow style, an item a line."""
    return b"[\n" + b",\n".join(map(msgspec.json.encode, records)) + b"\n]\n"
