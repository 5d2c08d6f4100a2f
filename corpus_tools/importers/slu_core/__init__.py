"""Importer of the AAAI-11 corpus in the layout of the repository h2r/slu_core.

Read :mod:`~corpus_tools.importers.slu_core.slu_corpus` first: it puts the corpus together
from what ``files`` finds, ``trees`` makes of the SDCs, ``worlds`` of the objects, places
and paths, and ``tables`` of the assignments and judgments.
"""
