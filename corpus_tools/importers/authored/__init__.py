"""The importer of authored corpora: scenarios and commands written by hand in YAML.

``docs/authored-corpora.md`` describes the files. Read
:mod:`corpus_tools.importers.authored.authored_files` first (what the files hold), then ``worlds``
(contexts with logs), ``clauses`` (trees and groundings), ``consistency`` (whether they fit the
log), ``negatives`` (random groundings) and ``assembly``, which does it all.
"""
