"""Deprecated names: :class:`~corpus_tools.corpus.corpus_model.Corpus` reads corpora."""

from __future__ import annotations

from corpus_tools.corpus import decoding
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.deprecated_names import deprecated_name

_REPLACEMENTS = {
    "load_corpus": ("Corpus.load", Corpus.load),
    "read_manifest": ("corpus_tools.corpus.decoding.read_manifest", decoding.read_manifest),
}


def __getattr__(name: str) -> object:
    return deprecated_name(__name__, name, _REPLACEMENTS)
