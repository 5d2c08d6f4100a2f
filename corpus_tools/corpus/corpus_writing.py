"""Deprecated names: :class:`~corpus_tools.corpus.corpus_model.Corpus` writes corpora."""

from __future__ import annotations

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_validation import seal
from corpus_tools.corpus.deprecated_names import deprecated_name

_REPLACEMENTS = {
    "write_corpus": ("Corpus.save", Corpus.save),
    "check_writable": ("Corpus.check_target", Corpus.check_target),
    "corpus_files": ("Corpus.files", Corpus.files),
    "seal": ("corpus_tools.corpus.corpus_validation.seal", seal),
}


def __getattr__(name: str) -> object:
    return deprecated_name(__name__, name, _REPLACEMENTS)
