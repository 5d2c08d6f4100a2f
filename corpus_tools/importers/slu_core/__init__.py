"""Importer of the AAAI-11 corpus in the layout of the repository h2r/slu_core.

Read :mod:`~corpus_tools.importers.slu_core.slu_corpus` first: it puts the corpus together.
``slu_files`` finds the files. ``slu_trees`` reads SDCs, ``slu_worlds`` objects, places and paths,
and ``slu_tables`` assignments and judgments.
"""
