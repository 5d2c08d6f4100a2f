"""Importers: corpora in other formats, read into the toolkit's own.

Read :mod:`corpus_tools.importers.importer_registry` first (what an importer is and which there
are), then :mod:`corpus_tools.importers.report` (what an import reports), then one importer, such as
:mod:`corpus_tools.importers.slu_core`.
"""
