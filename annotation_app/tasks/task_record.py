"""Record of a task: the form of its answers, its page, and the items made of its answers.

A task is one record. The rest of the app, from leases to exports, uses the record and knows no
task by its name. ``docs/how-to/new-task.md`` shows how to add one.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import IO, Any, NamedTuple

import msgspec
from flask import Blueprint
from sqlalchemy.orm import Session

from annotation_app.core.languages import N_
from annotation_app.core.problems import FieldProblem
from annotation_app.items.assignment import AnyItem
from annotation_app.items.new_items import NewItem
from annotation_app.store.models import Answer, Item, Record, Study
from annotation_app.studies.study_file import StudyConfig, TaskConfig
from annotation_app.tasks.agreement import Agreement, ModelErrors, Part
from annotation_app.tasks.corpus_parts import CorpusParts
from annotation_app.tasks.episode_parts import EpisodeParts
from annotation_app.tasks.practice_example import OwnPractice, PracticeExample
from corpus_tools.exporters.csv_tables import write_rows
from corpus_tools.world.scenarios.documents import Problem
from g3.short_repr import short_repr

COMMAND, CLAUSES, GROUNDINGS = "command", "clauses", "groundings"
"""Kinds of content that answers give, and items are made of."""
LONGEST_NAME = 20
"""Characters that the database has for a task's name."""


class StyleWords(NamedTuple):
    """A style of text that people write, in words."""

    title: str
    prompt: str
    """Request to write such a text."""
    is_usual: bool = False
    """True if a study that names no styles has it."""


@short_repr
@dataclass(frozen=True, slots=True)
class TaskWords:
    """A task in words. They name no object and no action of any video."""

    title: str
    """One word, usually a verb."""
    summary: str
    """Summary of the work, in one sentence."""
    offer: str
    """Summary for people at a crowd platform, who do it several times."""
    instructions: tuple[str, ...]
    """Preparatory instructions, a sentence or two each."""
    keys: tuple[tuple[str, str], ...] = ((N_("Ctrl Enter"), N_("send")),)
    """Each key of the page, and what it does."""
    prompt: str = ""
    """Request beside the control that people fill in, if the page shows it."""
    styles: Mapping[str, StyleWords] = field(default_factory=dict)
    """The styles of text that people write, if there are several, by their names."""


@short_repr
@dataclass(frozen=True, slots=True)
class Source:
    """The origin of a task's items that are made of adopted answers."""

    made_of: str
    """Content that answers must give: `COMMAND`, `CLAUSES`, or another task's ``gives``."""
    items: Callable[[Session, StudyConfig, Item, Answer], Iterable[NewItem]]
    """Items that are made of an adopted answer to an item (:mod:`annotation_app.items.new_items`
    defines the prefixes of their subjects)."""
    shows: Callable[[Record, Answer], bool] = lambda _payload, _answer: False
    """True if an item of such a payload shows this answer's content. Such an item may stay when the
    data of another answer's author are erased. Not needed for items that are made of commands."""


@short_repr
@dataclass(frozen=True, slots=True)
class Suggestion:
    """A program's proposal for an item's answer."""

    value: Any
    """In the form that `Task.shown_suggestion` and `Task.likeness` take."""
    probability: float | None = None
    """Probability that it is right; None for what a corpus has or nobody has measured."""


@short_repr
@dataclass(frozen=True, slots=True)
class Compared:
    """Several answers to an item, as the page shows them that decides between them."""

    sides: tuple[Any, ...]
    """Data that the task's template shows of each answer."""
    about: Mapping[str, Any] = field(default_factory=dict)
    """Data that the template shows of all answers."""


@short_repr
@dataclass(frozen=True, slots=True)
class Adjudication:
    """The way in which people decide between differing answers to an item."""

    essence: Callable[[Record], Any]
    """Part that agreeing answers share."""
    agreement: Callable[[Record, Record], float]
    """Agreement of two answers, from 0 to 1."""
    compare: Callable[[Session, Item, Sequence[Record], bytes], Compared]
    """Data that the page shows of an item's answers. The last argument hides names of things."""
    opened: Callable[[Record, Record], Record]
    """Data with which the task's page begins with an answer: made of its usual data and the answer
    in the form in which the page sends it. The page's first state is ``data.start`` if that is
    given."""
    template: str
    """Template of the page that compares; it extends ``dashboard/compare.html``."""


@short_repr
@dataclass(frozen=True, slots=True)
class Counts:
    """The dashboard's counts of a task's answers.

    Parameters
    ----------
    type
        A dataclass of numbers, or of dictionaries of numbers. Its fields' names are new.
    of
        The counts of answers: for each its body, and whether it was adopted.
    labels
        Names of the fields that have a tile on the dashboard.
    template
        Template of the dashboard's further content, if there is more.
    """

    type: type[Any]
    of: Callable[[Sequence[tuple[Record, bool]]], Any]
    labels: Mapping[str, str]
    template: str = ""


@short_repr
@dataclass(frozen=True, slots=True)
class AnswerTable:
    """A file made of answers: its button's text, its type, the function that writes it, its rows.

    It writes to a file as it reads answers, so that those of a large study take little memory.
    """

    label: str
    media_type: str
    write: Callable[[Session, Study, IO[bytes]], None]
    about: str = ""


def write_csv(file: IO[bytes], columns: Sequence[str], rows: Iterable[Iterable[object]]) -> None:
    """Write a header and rows as UTF-8; no cell is taken for a formula. The file stays open."""
    text = io.TextIOWrapper(file, encoding="utf-8", newline="")
    try:
        write_rows(text, columns, rows)
    finally:
        text.detach()


def asked_styles(config: TaskConfig, words: TaskWords) -> dict[str, StyleWords]:
    """Return the styles of text that a study asks for, in the task's order."""
    return {
        name: style
        for name, style in words.styles.items()
        if (name in config.styles if config.styles else style.is_usual)
    }


VIDEO_KEYS = (
    ("K", N_("play the video, or pause")),
    (", .", N_("one frame back, or on")),
    ("< >", N_("play slower, or faster")),
    (N_("Ctrl Enter"), N_("send")),
)
"""Keys of the player, for tasks with a video, and that which sends."""
EDITOR_KEYS = ((N_("Ctrl Z, Ctrl Y"), N_("undo, redo")), *VIDEO_KEYS)


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
    """Words that people read."""
    template: str
    """Template of the page; it extends ``task.html``."""
    answer: type[msgspec.Struct]
    """The form in which the page sends an answer."""
    payload: Callable[[Session, Item, bytes], Record]
    """Data of an item that the page gets, and nothing beyond them."""
    check: Callable[[Session, AnyItem, Any, bytes], tuple[Record, Sequence[FieldProblem]]]
    """Answer in its kept form, and its faults. A kept answer has real names, a sent one has the
    names that the page got."""
    sent_form: Callable[[Session, Item, Record, bytes], Record] = _as_kept
    """A kept answer in the form in which the page sends it."""
    blueprint: Blueprint | None = None
    """Serves the files of a task that comes from another distribution."""
    example: Callable[[PracticeExample], Record] | None = None
    """Data of the practice page; without them there is no practice."""
    own_example: Callable[[OwnPractice], Record] = lambda own: {
        "command": own.item.command,
        **own.watched(),
    }
    """The same for a study's own practice item, if the task has `practises`."""
    hides_title: bool = False
    """True if the page leaves out the study's title, which may name the videos' contents."""
    suggestion: Callable[[Session, Item], Suggestion | None] | None = None
    """Program's suggestion for an item, None if there is none. The page gets its value, or None
    where the study, the draw or its probability withholds it, as ``"suggestion"`` of its
    payload."""
    suggested_from: float = 0.0
    """Least probability of a suggestion that is shown, unless the study has one."""
    suggested_from_why: str = ""
    """Measurement behind `suggested_from`, for those who set up studies."""
    shown_suggestion: Callable[[Session, Item, Any, bytes], Any] = _as_kept
    """Suggestion in the page's form, if that differs: with the names that people read."""
    likeness: Callable[[Any, Record], float] | None = None
    """Likeness of a kept answer to a suggestion, from 0 to 1. A task with suggestions has it."""
    fates: Callable[[Any, Record], Record] | None = None
    """Fates of a suggestion's parts in a kept answer, for the answer's provenance."""
    suggests_in_english: bool = True
    """True if its program knows no other language; False if suggestions come with the data."""
    reads: tuple[str, ...] = ()
    """Fields of a study's file that the page shows, in addition to those of the task itself."""
    needs_scenes: bool = False
    """True if the things in the videos and their places must be known."""
    lets_draw: bool = False
    """True if a study may let people draw things that nobody has marked."""
    watches: Callable[[Record], Sequence[str]] = _none
    """Videos, by their names, that people must have watched to answer an item of such a payload."""
    practises: tuple[str, ...] = ()
    """Content that a study's own practice items must have; empty if the task has none."""
    warm_up: Callable[[], None] | None = None
    """Called before the app serves a study with the task."""

    gives: str = ""
    """Content that adopted answers give to other tasks' items. The answers of a task that gives
    `COMMAND` have a ``"text"``."""
    source: Source | None = None
    """Origin of items that are made of answers."""
    without_scenes: Source | None = None
    """Origin of items for videos whose things are unknown, instead of `source`. It makes none for
    others."""
    of_video: Callable[[str, str], NewItem] | None = None
    """The item about a video, from its name and its SHA-256, for tasks that begin with videos."""
    of_study: Callable[[StudyConfig], Iterable[NewItem]] = _none
    """Items that a study's file asks for."""
    study_problem: Callable[[StudyConfig], Problem | None] = lambda _study: None
    """Fault in a study file's settings for this task; with one the study may not have it."""
    in_random_order: bool = False
    """True if each person gets the items in a random order of their own."""
    passes: Callable[[Record, Record], bool] | None = None
    """True if an attention check was answered well, from its payload and the answer. A task with it
    has attention checks."""
    adjudication: Adjudication | None = None
    """Way in which people decide between answers; without it each answer is adopted at once."""

    export: Callable[[CorpusParts], None] = lambda _parts: None
    """Adds to an exported corpus what the answers make."""
    episodes: Callable[[EpisodeParts], None] = lambda _parts: None
    """Adds to a copy of a LeRobot dataset what the answers make."""
    counts: Counts | None = None
    """The dashboard's counts."""
    agreement: Sequence[Agreement] = ()
    """Measures of agreement between people (:func:`annotation_app.tasks.agreement.choices`)."""
    model_errors: Callable[[Session, Study], Sequence[ModelErrors]] = _none
    """Errors of the models whose suggestions people corrected, one record a model and group."""
    gist: Callable[[Record], Record] | None = None
    """The part of a kept answer that `counts`, `agreement`, `verdict`, `oddities` and `passes`
    read. With it
    the dashboard of a large study is faster: equal gists are read once."""
    facts: Callable[[Session, Item, Record], Sequence[tuple[str, str]]] = _none
    """Facts of a kept answer in words: its subject, and the answer."""
    disputed: Callable[[Item, Sequence[Record]], Iterable[Part]] = _none
    """The parts of an item's answers, two or more, on which people may disagree."""
    verdict: Callable[[Record], int] | None = None
    """Class of a kept answer, from 0, by which people's errors are estimated (Dawid and Skene)."""
    oddities: Callable[[Sequence[Record]], Iterator[str]] | None = None
    """Oddities of the answers of one person, in plain words."""
    tables: Mapping[str, AnswerTable] = field(default_factory=dict)
    """The files that can be made of its answers, by the names of their formats."""

    @property
    def has_disputes(self) -> bool:
        """True if the task shows the parts of its answers on which people disagree."""
        return self.disputed is not _none

    @property
    def sources(self) -> tuple[Source, ...]:
        """The origins of items that are made of answers."""
        return tuple(s for s in (self.source, self.without_scenes) if s is not None)
