"""Outcomes of commands under the automatic judge, and figures of them."""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypedDict

import msgspec
import numpy as np

from corpus_tools.corpus.estimate import Estimate, part, undefined
from g3.short_repr import short_repr
from g3.storage.atomic_file import write_bytes

BINS = 10
"""Bins of the reliability diagram."""


@short_repr
@dataclass(frozen=True, slots=True)
class Outcome:
    """The outcome of one command in one configuration.

    Parameters
    ----------
    probability
        Probability of its plan; 0 where there is none.
    reason
        Reason for a wrong plan; empty if it is right.
    objects, objects_right
        Number of annotated OBJECTs, and of those grounded as annotated.
    evidence
        Evidence from which the probability was calibrated; empty where there is no plan.
    by_words
        The judge's second verdict, by the command's words; None if it can't judge.
    words_reason
        Reason for a second verdict of wrong, or for its absence; empty otherwise.
    theme
        True if it picks up the right things and no other; None where that isn't known.
    refused
        True if there is no plan, which counts as wrong.
    heading
        Rule of the robot's heading at the start; empty for the corpus's own.
    """

    command: str
    scenario: str
    text: str
    probability: float
    correct: bool
    reason: str
    objects: int = 0
    objects_right: int = 0
    evidence: tuple[float, ...] = ()
    by_words: bool | None = None
    words_reason: str = ""
    theme: bool | None = None
    refused: bool = False
    heading: str = ""


class Bin(TypedDict):
    """Plans with about the same stated probability."""

    stated: float
    correct: float
    n: int


def grounding_accuracy(outcomes: Sequence[Outcome]) -> Estimate:
    """Return the share of annotated OBJECTs grounded as annotated in the best plan.

    It has no interval.
    """
    total = sum(o.objects for o in outcomes)
    return part(sum(o.objects_right for o in outcomes), total, "no data")


def reliability(outcomes: Sequence[Outcome]) -> tuple[Estimate, list[Bin]]:
    """Return plans' expected calibration error, and the reliability diagram.

    The error has no interval.
    """
    if not outcomes:
        return undefined("no data"), []
    given = np.array([o.probability for o in outcomes])
    correct = np.array([o.correct for o in outcomes], dtype=float)
    place = np.minimum((given * BINS).astype(int), BINS - 1)
    rows: list[Bin] = []
    error = 0.0
    for i in np.unique(place):
        own = place == i
        stated, true = float(given[own].mean()), float(correct[own].mean())
        error += float(own.mean()) * abs(stated - true)
        rows.append({"stated": stated, "correct": true, "n": int(own.sum())})
    return Estimate(error), rows


def risk_coverage(outcomes: Sequence[Outcome]) -> Estimate:
    """Return the area under the risk–coverage curve: the error of the k most probable.

    It is the mean over all k, 0 at best; with uninformative probabilities, about the share of all
    plans that is wrong. It has no interval.
    """
    if not outcomes:
        return undefined("no data")
    order = sorted(outcomes, key=lambda o: (-o.probability, o.command))
    wrong = np.array([not o.correct for o in order], dtype=float)
    return Estimate(float((np.cumsum(wrong) / np.arange(1, len(wrong) + 1)).mean()))


SUFFIX = ".part"
"""Suffix of the kept file, beside the table's own file."""

logger = logging.getLogger(__name__)

Outcomes = dict[str, list[Outcome]]


class _File(msgspec.Struct, frozen=True):
    settings: dict[str, Any]
    scenarios: dict[str, Outcomes]
    digest: str = ""


def _digest(content: _File) -> str:
    rest = msgspec.structs.replace(content, digest="")
    return f"sha256:{hashlib.sha256(msgspec.json.encode(rest, order='sorted')).hexdigest()}"


@short_repr
@dataclass(frozen=True, slots=True)
class Kept:
    """The outcomes of finished scenarios, by scenario and configuration."""

    path: Path
    settings: Mapping[str, object]
    scenarios: dict[str, Outcomes] = field(default_factory=dict)

    def keep(self, scenario: str, outcomes: Mapping[str, Sequence[Outcome]]) -> None:
        """Add a finished scenario."""
        self.scenarios[scenario] = {name: list(own) for name, own in outcomes.items()}
        content = _File(dict(self.settings), self.scenarios)
        sealed = msgspec.structs.replace(content, digest=_digest(content))
        write_bytes(self.path, msgspec.json.encode(sealed))


def kept_beside(out: Path, settings: Mapping[str, object]) -> Kept:
    """Return the outcomes kept by an earlier run of the same table; else none.

    A damaged file also gives none: its scenarios are run again. The settings decide the outcomes,
    in the form in which JSON has them.
    """
    path = out.with_name(f"{out.name}{SUFFIX}")
    try:
        file = msgspec.json.decode(path.read_bytes(), type=_File)
        damaged = file.digest != _digest(file)
    except FileNotFoundError:
        return Kept(path, settings)
    except (OSError, msgspec.MsgspecError, UnicodeDecodeError, RecursionError):
        damaged = True
    if damaged:
        logger.warning("%s: the file is damaged; what it kept is done again", path)
        return Kept(path, settings)
    same = file.settings == settings
    return Kept(path, settings, file.scenarios if same else {})
