"""Records in the files of a corpus: one typed record a line.

The records are the file format: JSON Schemas are made from them, and a change here is a
change of the format. They are kept apart from the domain types of :mod:`g3`, which can
then change without changing files.
"""

from __future__ import annotations

from typing import Annotated, TypeAlias

import msgspec

from g3.annotation import Put, Rating, Source, Unknown
from g3.groundings import Aspect, Colour
from g3.sdc.clauses import SDCType

SCHEMA_VERSION = 2
"""Version 1, which can be read, too, has no digests."""

MANIFEST = "corpus.json"
CONTEXTS = "contexts.jsonl"
COMMANDS = "commands.jsonl"
ANNOTATIONS = "annotations.jsonl"
JUDGMENTS = "judgments.jsonl"
OUTCOMES = "outcomes.jsonl"
TRAJECTORIES = "trajectories.npz"

Index: TypeAlias = Annotated[int, msgspec.Meta(ge=0)]
Word: TypeAlias = tuple[Index, str]
"""Offset of a word's first character in the command, and the word."""


class _Record(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Base of all records."""


class PrismRecord(_Record, frozen=True):
    """An upright prism: corners of the footprint and two heights, in metres."""

    xy: tuple[tuple[float, float], ...]
    z_min: float
    z_max: float


class ObjectRecord(_Record, frozen=True):
    """A physical object; its trajectory is an index into trajectories.npz.

    ``liftable`` says whether the robot can lift it, and ``colours`` what colours it has, where
    somebody has stated them.
    """

    id: str
    labels: tuple[str, ...]
    prism: PrismRecord
    trajectory: Index
    liftable: bool | None = None
    colours: tuple[Colour, ...] = ()


class PlaceRecord(_Record, frozen=True):
    """A region of the world, named or not."""

    prism: PrismRecord
    name: str = ""


class ContextRecord(_Record, frozen=True):
    """A line of contexts.jsonl: the semantic map that commands were given in.

    ``assumed`` lists what was not recorded: ids of objects, and what of them is assumed.
    """

    id: str
    agent_id: str
    objects: tuple[ObjectRecord, ...]
    places: tuple[PlaceRecord, ...]
    assumed: tuple[tuple[str, Aspect], ...] = ()


class CommandRecord(_Record, frozen=True):
    """A line of commands.jsonl: what one subject typed for one video."""

    id: str
    text: str
    scenario: str
    video: str = ""
    subject: str = ""


class SDCRecord(_Record, frozen=True):
    """A spatial description clause; empty fields are left out."""

    type: SDCType
    words: tuple[Word, ...] = ()
    relation: tuple[Word, ...] = ()
    figure: tuple[SDCRecord, ...] = ()
    landmark1: tuple[SDCRecord, ...] = ()
    landmark2: tuple[SDCRecord, ...] = ()


class ObjectReference(_Record, frozen=True, tag_field="kind", tag="reference"):
    """A grounding that is an object of the annotation's context, or of another one."""

    object: str
    context: str = ""


class ObjectGrounding(ObjectRecord, frozen=True, tag_field="kind", tag="object"):
    """A grounding that is an object of no context in the corpus."""


class PlaceGrounding(PlaceRecord, frozen=True, tag_field="kind", tag="place"):
    """A grounding that is a region."""


class PathGrounding(_Record, frozen=True, tag_field="kind", tag="path"):
    """A grounding that is a path; its trajectory is an index into trajectories.npz."""

    trajectory: Index


GroundingRecord: TypeAlias = ObjectReference | ObjectGrounding | PlaceGrounding | PathGrounding


class AnnotationRecord(_Record, frozen=True):
    """A line of annotations.jsonl: SDC trees, and groundings and a label per clause.

    ``groundings`` and ``correct`` follow the clauses breadth first: the top-level
    clauses, then their children in the order figure, landmark1, landmark2, and so on.
    ``taken_back`` are the words that the person takes back; they are in no clause.
    """

    id: str
    command: str
    context: str
    source: Source
    sdcs: tuple[SDCRecord, ...]
    groundings: tuple[tuple[GroundingRecord, ...], ...]
    correct: tuple[bool | None, ...]
    taken_back: tuple[Word, ...] = ()


class JudgmentRecord(_Record, frozen=True):
    """A line of judgments.jsonl: one person's rating of a command shown with a video."""

    id: str
    command: str
    command_video: str
    shown_video: str
    rating: Rating
    study: str
    subject: str = ""


class OutcomeRecord(_Record, frozen=True):
    """A line of outcomes.jsonl: what the robot did in a task.

    It belongs to all commands of the scenario, or to the command or the video that it names.
    """

    id: str
    scenario: str
    context: str
    command: str = ""
    video: str = ""
    picked: tuple[str, ...] = ()
    put: Put = ""
    on: tuple[str, ...] = ()
    checkpoint: int | None = None
    unknown: tuple[Unknown, ...] = ()
    log: str = ""


class Counts(_Record, frozen=True):
    """How many records each file holds."""

    contexts: int
    commands: int
    annotations: int
    judgments: int
    trajectories: int
    outcomes: int = 0


class Manifest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The file corpus.json: what the corpus is and how much it holds.

    ``hash`` covers the content without the subjects, so it doesn't depend on the salt.
    ``digests`` cover everything, file by file; corpora of version 1 have none.
    """

    schema_version: int
    name: str
    source: str
    licence: str
    hash: str
    counts: Counts
    digests: dict[str, str] = {}


LINE_RECORDS: dict[str, type[msgspec.Struct]] = {
    CONTEXTS: ContextRecord,
    COMMANDS: CommandRecord,
    ANNOTATIONS: AnnotationRecord,
    JUDGMENTS: JudgmentRecord,
    OUTCOMES: OutcomeRecord,
}
"""The record type of each JSONL file."""
