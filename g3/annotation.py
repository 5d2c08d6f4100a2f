"""Commands, their grounded SDC trees, their outcomes, and people's ratings (section 4.1)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

from g3 import html_view
from g3.data_frames import data_frame
from g3.groundings import Context, Grounding, PhysicalObject, Place
from g3.sdc.clauses import SDC, Span, all_words, breadth_first
from g3.sdc.sdc_drawing import to_svg
from g3.short_repr import short_repr

if TYPE_CHECKING:
    import pandas as pd

Source = Literal["positive", "random", "easy", "hard"]
"""Origin of an annotation's groundings.

``positive``: an annotator's groundings. ``random``: a random grounding per SDC,
re-annotated where it happens to be right. ``easy``: an object that is plainly wrong.
``hard``: a plausible candidate from the command's own start state
(:mod:`g3.negatives.hard_negatives`).
"""
SOURCES: tuple[Source, ...] = get_args(Source)

_LABELS = {True: "right", False: "wrong", None: "-"}


def _called(grounding: Grounding) -> str:
    if isinstance(grounding, PhysicalObject):
        return f"{' '.join(grounding.labels)} {grounding.id}"
    return grounding.name or "a place" if isinstance(grounding, Place) else "a path"


Rating = Literal["SD", "D", "N", "A", "SA"]
"""Strongly disagree, disagree, neutral, agree, strongly agree."""
RATINGS: tuple[Rating, ...] = get_args(Rating)


@short_repr
@dataclass(frozen=True, slots=True)
class Command:
    """A command that one subject typed for one video.

    Parameters
    ----------
    id
        Unique in the corpus.
    text
        The command as typed.
    scenario
        Name of the scenario that the video shows.
    video
        Id of the video.
    subject
        Salted hash of the worker's id; empty if unknown.
    """

    id: str
    text: str
    scenario: str
    video: str = ""
    subject: str = ""


@short_repr
@dataclass(frozen=True, slots=True)
class Annotation:
    """A command's SDC trees with a grounding and a label for each clause.

    Parameters
    ----------
    id
        Unique in the corpus.
    context
        The semantic map in which it was given.
    sdcs
        The top-level clauses.
    groundings
        For each clause in breadth-first order (:func:`g3.sdc.clauses.breadth_first`) its
        groundings: none if it has not been grounded, several for a plural.
    correct
        For each clause whether its groundings are right, or None where nobody judged it.
    taken_back
        Words of the command that its person takes back ("the red one, no, the blue one"). They are
        in no clause.
    """

    id: str
    command: Command
    context: Context
    sdcs: tuple[SDC, ...]
    groundings: tuple[tuple[Grounding, ...], ...]
    correct: tuple[bool | None, ...]
    source: Source
    taken_back: tuple[Span, ...] = ()

    def to_pandas(self) -> pd.DataFrame:
        """Return a row for each clause: type, words, groundings, label."""
        names = ("clause", "words", "grounded_in", "correct")
        rows = zip(self._clauses(), self.correct, strict=True)
        return data_frame(dict(zip(names, (*row, label), strict=True)) for row, label in rows)

    def _clauses(self) -> Iterator[tuple[str, str, str]]:
        for clause, group in zip(breadth_first(self.sdcs), self.groundings, strict=True):
            words = " ".join(word.text for word in all_words(clause))
            yield clause.type, words, ", ".join(map(_called, group))

    def _repr_html_(self) -> str:
        """Show the command, its clauses drawn, and their groundings."""
        rows = [
            (kind, words or "(implicit)", group or "-", _LABELS[label])
            for (kind, words, group), label in zip(self._clauses(), self.correct, strict=True)
        ]
        return "\n".join(
            [
                html_view.heading(self.command.text, self.id, self.source),
                to_svg(self.sdcs),
                html_view.table(("clause", "words", "grounded in", "label"), rows),
            ]
        )


@short_repr
@dataclass(frozen=True, slots=True)
class Judgment:
    """One person's rating of a command shown with a video (Table 2).

    Parameters
    ----------
    id
        Unique in the corpus.
    command
        Text of the command shown.
    command_video
        The video that the command was typed for.
    shown_video
        The video that it was shown with.
    rating
        Agreement with "the forklift in the video is executing the above command".
    subject
        Salted hash of the rater's id.
    study
        Its study.
    """

    id: str
    command: str
    command_video: str
    shown_video: str
    rating: Rating
    subject: str
    study: str


Put = Literal["on", "ground", "held", ""]
"""End of a load: on a thing, on the ground, or nowhere, because the robot still held it at the end.
Empty if nothing was put anywhere, or it isn't known."""

Unknown = Literal["picked", "put", "on", "place", "rest"]
"""Parts of a task's outcome that a log leaves open.

``picked``: what was picked up. ``put``: where it was put. ``on``: on which of several things.
``place``: where exactly it ended. ``rest``: whether more was done, as something in the log was
not understood.
"""
UNKNOWNS: tuple[Unknown, ...] = get_args(Unknown)


@short_repr
@dataclass(frozen=True, slots=True)
class TaskOutcome:
    """Outcome of a task. A video may show several, in the order of their log.

    Parameters
    ----------
    id
        Unique in the corpus.
    scenario
        Scenario of the video: the outcome is that of all its commands, unless `command` or `video`
        says otherwise.
    context
        Id of the context whose objects are named.
    command
        Id of the only command that it belongs to; empty if there is no such one.
    video
        Id of the only video that it belongs to; empty if there is no such one.
    picked
        Ids of the things that were picked up; none when the robot only drove.
    put
        Their final place.
    on
        Ids of the things on which they were put: several, if it was on one of them and
        nobody knows which. ``on`` is among the unknown then.
    checkpoint
        Number of the checkpoint where the task ended, in the robot's own map.
    unknown
        The unknown parts.
    log
        The line of the log that these were read from.
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
