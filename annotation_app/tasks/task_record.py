"""What a task of the app is: the form of its answers, its page, and what is made of answers.

A task is one record. All else, from leases to exports, uses the record and knows no task by its
name. ``docs/how-to/new-task.md`` shows how to add one.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import IO, Any

import msgspec
from flask import Blueprint
from sqlalchemy.orm import Session

from annotation_app.core.languages import N_
from annotation_app.core.problems import FieldProblem
from annotation_app.items.assignment import AnyItem
from annotation_app.items.new_items import NewItem
from annotation_app.store.models import Answer, Item, Record, Study
from annotation_app.studies.study_file import StudyConfig
from annotation_app.tasks.agreement import Measured, Part
from annotation_app.tasks.corpus_parts import CorpusParts
from annotation_app.tasks.practice_example import PracticeExample
from corpus_tools.exporters.csv_tables import write_rows
from corpus_tools.world.scenarios.documents import Problem
from g3.short_repr import short_repr

COMMAND, CLAUSES, GROUNDINGS = "command", "clauses", "groundings"
"""What answers give, and items are made of."""
LONGEST_NAME = 20
"""Characters that the database has for a task's name."""


@short_repr
@dataclass(frozen=True, slots=True)
class TaskWords:
    """A task in words. They name no object and no action of any video."""

    title: str
    """One word, usually a verb."""
    summary: str
    """What people do, in one sentence."""
    offer: str
    """The same for people at a crowd platform, who do it several times."""
    instructions: tuple[str, ...]
    """What to know before, a sentence or two each."""
    keys: tuple[tuple[str, str], ...] = ((N_("Ctrl Enter"), N_("send")),)
    """Each key of the page, and what it does."""


@short_repr
@dataclass(frozen=True, slots=True)
class Source:
    """Where a task's items come from, if they are made of adopted answers."""

    made_of: str
    """What answers must give: `COMMAND`, `CLAUSES`, or what another task's ``gives`` says."""
    items: Callable[[Session, StudyConfig, Item, Answer], Iterable[NewItem]]
    """The items that are made of an adopted answer to an item
    (:mod:`annotation_app.items.new_items` tells how their subjects begin)."""
    shows: Callable[[Record, Answer], bool] = lambda _payload, _answer: False
    """Whether an item of such a payload shows what an answer holds. It says whether an item may
    stay when the data of another answer's author are erased. It isn't needed for items that are
    made of commands."""


@short_repr
@dataclass(frozen=True, slots=True)
class Compared:
    """Several answers to an item, as the page shows them that decides between them."""

    sides: tuple[Any, ...]
    """What the task's template shows of each answer."""
    about: Mapping[str, Any] = field(default_factory=dict)
    """What it shows of all of them."""


@short_repr
@dataclass(frozen=True, slots=True)
class Adjudication:
    """How people decide between answers to an item that differ."""

    essence: Callable[[Record], Any]
    """What two answers must share to agree."""
    agreement: Callable[[Record, Record], float]
    """How much two answers agree, from 0 to 1."""
    compare: Callable[[Session, Item, Sequence[Record], bytes], Compared]
    """What the page shows of an item's answers. The last argument hides the names of things."""
    opened: Callable[[Record, Record], Record]
    """What the task's page gets so that its editor begins with an answer: made of what it gets
    anyway and the answer in the form in which the page sends it. The page's first state is
    ``data.start`` if that is given."""
    template: str
    """Of the page that compares; it extends ``dashboard/compare.html``."""


@short_repr
@dataclass(frozen=True, slots=True)
class Counts:
    """What the dashboard counts of a task's answers.

    Parameters
    ----------
    type
        A dataclass of numbers, or of dictionaries of numbers. Its fields' names are new.
    of
        The counts of answers: for each its body, and whether it was adopted.
    labels
        What the fields are called that have a tile on the dashboard.
    template
        Of what the dashboard shows besides, if it shows more.
    """

    type: type[Any]
    of: Callable[[Sequence[tuple[Record, bool]]], Any]
    labels: Mapping[str, str]
    template: str = ""


@short_repr
@dataclass(frozen=True, slots=True)
class AnswerTable:
    """A file that can be made of answers: what its button says, its type, what writes it.

    It writes to a file as it reads answers, so that those of a large study take little memory.
    """

    label: str
    media_type: str
    write: Callable[[Session, Study, IO[bytes]], None]


def write_csv(file: IO[bytes], columns: Sequence[str], rows: Iterable[Iterable[object]]) -> None:
    """Write a header and rows as UTF-8; no cell is taken for a formula. The file stays open."""
    text = io.TextIOWrapper(file, encoding="utf-8", newline="")
    try:
        write_rows(text, columns, rows)
    finally:
        text.detach()


VIDEO_KEYS = (
    ("K", N_("play the video, or pause")),
    (", .", N_("one frame back, or on")),
    ("< >", N_("play slower, or faster")),
)
"""Keys of the player, for tasks with a video."""


def _none(*_of: Any) -> tuple[()]:
    return ()


def _as_kept(_session: Session, _item: Item, body: Record, _salt: bytes) -> Record:
    return body


@short_repr
@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """A task. What has a default here can be left out."""

    name: str
    """In study files, addresses and the database: lower-case letters, at most 20."""
    words: TaskWords
    """What people read."""
    template: str
    """Of the page; it extends ``task.html``."""
    answer: type[msgspec.Struct]
    """The form in which the page sends an answer."""
    payload: Callable[[Session, Item, bytes], Record]
    """What the page gets of an item, and nothing beyond it."""
    check: Callable[[Session, AnyItem, Any, bytes], tuple[Record, Sequence[FieldProblem]]]
    """An answer as it is kept, and what is wrong with it. What is kept has real names, what the
    page sends has those that the page was told."""
    sent_form: Callable[[Session, Item, Record, bytes], Record] = _as_kept
    """A kept answer in the form in which the page sends it."""
    blueprint: Blueprint | None = None
    """Serves the files of a task that comes from another distribution."""
    example: Callable[[PracticeExample], Record] | None = None
    """What the page gets for practice; without it there is no practice."""
    hides_title: bool = False
    """Whether the page leaves out the study's title, which may name what is in the videos."""
    suggestion: Callable[[Session, Item], Any] | None = None
    """What a program suggests for an item, None if nothing. The page gets it, or None where the
    study or the draw withholds it, as ``"suggestion"`` of its payload."""
    shown_suggestion: Callable[[Session, Item, Any, bytes], Any] = _as_kept
    """A suggestion as the page gets it, if that differs: with the names that people are told."""
    likeness: Callable[[Any, Record], float] | None = None
    """How much a kept answer is like a suggestion, from 0 to 1. A task with suggestions has it."""
    reads: tuple[str, ...] = ()
    """The fields of a study's file that its page shows, besides those of the task itself."""
    needs_scenes: bool = False
    """Whether it must be known what is where in the videos."""
    practises: tuple[str, ...] = ()
    """What a study's own practice items must have; empty if the task has none."""
    warm_up: Callable[[], None] | None = None
    """Called before the app serves a study with the task."""

    gives: str = ""
    """What its adopted answers give to other tasks' items. The answers of a task that gives
    `COMMAND` have a ``"text"``."""
    source: Source | None = None
    """Where items come from that are made of answers."""
    without_scenes: Source | None = None
    """Where items come from instead for videos of which nobody knows what is where. It makes none
    for others."""
    of_video: Callable[[str, str], NewItem] | None = None
    """The item about a video, from its name and its SHA-256, for tasks that begin with videos."""
    of_study: Callable[[StudyConfig], Iterable[NewItem]] = _none
    """The items that a study's file asks for."""
    study_problem: Callable[[StudyConfig], Problem | None] = lambda _study: None
    """What is wrong with what a study's file says for this task; the study may not have it."""
    in_random_order: bool = False
    """Whether people get the items in a random order of their own."""
    passes: Callable[[Record, Record], bool] | None = None
    """Whether an attention check was answered well, from its payload and the answer. A task with it
    has attention checks."""
    adjudication: Adjudication | None = None
    """How people decide between answers; without it each answer is adopted at once."""

    export: Callable[[CorpusParts], None] = lambda _parts: None
    """Adds to an exported corpus what the answers make."""
    counts: Counts | None = None
    """What the dashboard counts."""
    agreement: Callable[[Sequence[Sequence[Record]]], Iterable[Measured]] = _none
    """How much people agree, from the answers to each item."""
    gist: Callable[[Record], Record] | None = None
    """The part of a kept answer that `counts`, `agreement`, `oddities` and `passes` read. With it
    the dashboard of a large study is faster: equal gists are read once."""
    disputed: Callable[[Item, Sequence[Record]], Iterable[Part]] = _none
    """The parts of an item's answers, two or more, on which people may disagree."""
    oddities: Callable[[Sequence[Record]], Iterator[str]] | None = None
    """What is odd about the answers of one person, in plain words."""
    tables: Mapping[str, AnswerTable] = field(default_factory=dict)
    """The files that can be made of its answers, by the names of their formats."""

    @property
    def has_disputes(self) -> bool:
        """Whether it shows on which parts of its answers people disagree."""
        return self.disputed is not _none

    @property
    def sources(self) -> tuple[Source, ...]:
        """Where items come from that are made of answers."""
        return tuple(s for s in (self.source, self.without_scenes) if s is not None)
