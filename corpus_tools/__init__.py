"""Everything that makes, stores and moves corpora. Read :mod:`corpus_tools.corpus` first."""

__version__ = "0.1.0"
