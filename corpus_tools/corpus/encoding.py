"""Deprecated names: :class:`~corpus_tools.corpus.corpus_model.Corpus` puts corpora together."""

from __future__ import annotations

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.deprecated_names import deprecated_name


def _unchanged(corpus: Corpus) -> Corpus:
    return corpus


_REPLACEMENTS = {
    "make_corpus": ("Corpus.build", Corpus.build),
    "merged": ("Corpus.merge", Corpus.merge),
    "rehashed": ("the corpus itself, whose hash is always that of its content", _unchanged),
}


def __getattr__(name: str) -> object:
    return deprecated_name(__name__, name, _REPLACEMENTS)
