"""Commands, their grounded SDC trees, and what people said of them (section 4.1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from g3.groundings import Context, Grounding
from g3.sdc.clauses import SDC

Source = Literal["positive", "random", "easy", "hard"]
"""How an annotation's groundings came about.

``positive``: an annotator's groundings. ``random``: a random grounding per SDC,
re-annotated where it happens to be right. ``easy``: an object that is plainly wrong.
``hard``: a plausible candidate from the command's own start state
(:mod:`g3.negatives.hard_negatives`).
"""
SOURCES: tuple[Source, ...] = get_args(Source)

Rating = Literal["SD", "D", "N", "A", "SA"]
"""Strongly disagree, disagree, neutral, agree, strongly agree."""
RATINGS: tuple[Rating, ...] = get_args(Rating)


@dataclass(frozen=True, slots=True)
class Command:
    """What one subject typed for one video.

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


@dataclass(frozen=True, slots=True)
class Annotation:
    """A command's SDC trees with a grounding and a label for each clause.

    Parameters
    ----------
    id
        Unique in the corpus.
    command
        The command that is annotated.
    context
        The semantic map in which it was given.
    sdcs
        The top-level clauses.
    groundings
        For each clause in breadth-first order (:func:`g3.sdc.clauses.breadth_first`) its
        groundings: none if it has not been grounded, several for a plural.
    correct
        For each clause whether its groundings are right, or None where nobody said.
    source
        How the groundings came about.
    """

    id: str
    command: Command
    context: Context
    sdcs: tuple[SDC, ...]
    groundings: tuple[tuple[Grounding, ...], ...]
    correct: tuple[bool | None, ...]
    source: Source


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
        Which study it belongs to.
    """

    id: str
    command: str
    command_video: str
    shown_video: str
    rating: Rating
    subject: str
    study: str
