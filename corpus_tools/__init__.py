"""Everything that makes, stores and moves corpora. Read :mod:`corpus_tools.corpus` first."""

from g3 import __version__

__all__ = ["__version__"]
