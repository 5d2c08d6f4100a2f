"""Simulated ratings of commands shown with videos, and corpora with them.

The model: a pair has a quality, high for a command's own video and low for another one. A rater
sees it with a bias of their own and with noise, and puts it on the five points at fixed
thresholds. Some raters are careless and rate at random. With the values given here the parts of
the judgments that agree are near those of the paper's judgments (0.88 and 0.10).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import msgspec
import numpy as np

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.runtime.shipped import DATASET
from corpus_tools.world.scenarios.documents import read_document
from g3.annotation import RATINGS, Command, Judgment
from g3.errors import FormatError

STUDY = "simulated"
THRESHOLDS = (-1.5, -0.5, 0.5, 1.5)
"""Thresholds between the five points."""
RATERS = "raters.yaml"
"""The file that makes a folder a rated dataset: the rated corpus, and how it is rated."""
FIX = "docs/simulation.md describes the file"

T = TypeVar("T", bound=msgspec.Struct)


@dataclass(frozen=True, slots=True)
class RaterModel:
    """Distribution of ratings."""

    own: float = 1.9
    other: float = -1.2
    """Mean quality of a command with its own video, and with another scenario's."""
    spread: float = 0.6
    """Standard deviation of the quality among pairs."""
    bias: float = 0.4
    """Standard deviation of raters' biases."""
    noise: float = 0.7
    """Standard deviation of one rating."""
    careless: float = 0.03
    """Share of the raters who rate at random."""


def rate(
    corpus: Corpus,
    *,
    raters: int,
    judgments: int,
    seed: int,
    model: RaterModel | None = None,
) -> tuple[Judgment, ...]:
    """Rate each command with its own video and with one of another scenario.

    Each pair gets so many judgments, by different raters. FormatError if there are too few raters
    or scenarios.
    """
    model = model or RaterModel()
    commands = list(corpus.commands.values())
    scenarios = sorted({command.scenario for command in commands})
    if judgments > raters:
        raise FormatError(
            f"{raters} raters can't give {judgments} judgments of a pair", fix="ask for more raters"
        )
    if len(scenarios) < 2:
        raise FormatError(
            "a corpus with one scenario has no other videos", fix="take one with two at least"
        )
    rng = np.random.default_rng(seed)
    others = [_another(command, commands, rng) for command in commands]
    pairs = [(c, v) for c, o in zip(commands, others, strict=True) for v in (_video(c), o)]
    points = _points(pairs, raters, judgments, model, rng)
    return tuple(
        Judgment(
            id=f"{command.id}/{shown}/{rater}",
            command=command.text,
            command_video=_video(command),
            shown_video=shown,
            rating=RATINGS[point],
            subject=f"simulated-{rater:04}",
            study=STUDY,
        )
        for (command, shown), given in zip(pairs, points, strict=True)
        for rater, point in given
    )


def _video(command: Command) -> str:
    return command.video or command.scenario


def _another(command: Command, commands: Sequence[Command], rng: np.random.Generator) -> str:
    videos = sorted({_video(c) for c in commands if c.scenario != command.scenario})
    return videos[int(rng.integers(len(videos)))]


def _points(
    pairs: Sequence[tuple[Command, str]],
    raters: int,
    judgments: int,
    model: RaterModel,
    rng: np.random.Generator,
) -> list[list[tuple[int, int]]]:
    """Return for each pair its raters, and each one's choice of the five points."""
    bias = rng.normal(0, model.bias, raters)
    careless = rng.random(raters) < model.careless
    is_own_video = np.array([_video(command) == shown for command, shown in pairs])
    mean = np.where(is_own_video, model.own, model.other) + rng.normal(0, model.spread, len(pairs))
    ratings = []
    for quality in mean:
        chosen = rng.choice(raters, size=judgments, replace=False)
        seen = quality + bias[chosen] + rng.normal(0, model.noise, judgments)
        by_chance = rng.integers(len(RATINGS), size=judgments)
        points = np.where(careless[chosen], by_chance, np.searchsorted(THRESHOLDS, seen))
        ratings.append([(int(r), int(p)) for r, p in zip(chosen, points, strict=True)])
    return ratings


class Raters(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The file raters.yaml."""

    corpus: str
    """Name of a bundled corpus."""
    raters: int
    judgments: int
    seed: int


class _Dataset(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    name: str
    source: str
    licence: str


def with_simulated_ratings(corpus: Corpus, *, raters: int, judgments: int, seed: int) -> Corpus:
    """Replace a corpus's judgments by simulated ones, which its name and source state.

    The corpus's own judgments are not kept, so that simulated ones are never among people's.
    """
    return replace(
        corpus,
        name=f"{corpus.name}-simulated-ratings",
        judgments=rate(corpus, raters=raters, judgments=judgments, seed=seed),
        source=f"{corpus.source} The judgments are simulated; see docs/simulation.md.",
    )


def is_rated(folder: Path) -> bool:
    """Check that a folder is a rated dataset."""
    return (folder / RATERS).is_file()


def read_raters(folder: Path) -> Raters:
    """Read the raters of a rated dataset; a FormatError if they can't be read."""
    return _read(folder / RATERS, Raters)


def rated_corpus(folder: Path, corpus: Corpus) -> Corpus:
    """Make the corpus of a rated dataset.

    Parameters
    ----------
    folder
        The dataset.
    corpus
        The corpus that :func:`read_raters` names.
    """
    about, raters = _read(folder / DATASET, _Dataset), read_raters(folder)
    made = with_simulated_ratings(
        corpus, raters=raters.raters, judgments=raters.judgments, seed=raters.seed
    )
    return replace(made, name=about.name, source=about.source, licence=about.licence)


def _read(path: Path, kind: type[T]) -> T:
    try:
        return msgspec.convert(read_document(path, path.name).value, kind)
    except msgspec.ValidationError as error:
        raise FormatError(str(error), where=str(path), fix=FIX) from error
