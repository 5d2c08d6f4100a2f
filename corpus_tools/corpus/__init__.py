"""The corpus on disk: its format, reading, writing, checking and counting.

Read :mod:`corpus_tools.corpus.corpus_model` first (what a corpus is in memory), then
:mod:`corpus_tools.corpus.corpus_records` (what its files hold). ``reading.load_corpus`` and
``writing.write_corpus`` lead from one to the other through ``decoding`` and
``encoding``. The format is described in ``docs/corpus-format.md``.
"""
