"""Corpora with judgments of simulated raters."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import msgspec

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.runtime.shipped import DATASET
from corpus_tools.simulation.simulated_raters import rate
from corpus_tools.world.scenarios.documents import read_document
from g3.errors import FormatError

RATERS = "raters.yaml"
"""The file that makes a folder a rated dataset: the rated corpus, and how it is rated."""
FIX = "docs/simulation.md describes the file"

T = TypeVar("T", bound=msgspec.Struct)


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

    Raises
    ------
    FormatError
        If there are too few raters or scenarios.
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
