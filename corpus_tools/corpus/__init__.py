"""The corpus: its class, its format on disk, checks and counts.

Read :mod:`corpus_tools.corpus.corpus_model` first (the class ``Corpus``), then
:mod:`corpus_tools.corpus.corpus_records` (the records of its files). ``Corpus.load`` reads files by
``decoding``, ``Corpus.save`` writes them by ``corpus_tables``. The format is described in
``docs/corpus-format.md``.
"""
