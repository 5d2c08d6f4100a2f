"""The importer of authored corpora: scenarios and commands written by hand in YAML.

``docs/authored-corpora.md`` describes the files. Read
:mod:`~corpus_tools.importers.authored.authored_files` first: what the files hold, and contexts with
logs. Then read ``authored_clauses`` (trees and groundings, and whether they fit the log) and
``authored_negatives`` (random groundings). ``authored_corpus`` does it all.
"""
