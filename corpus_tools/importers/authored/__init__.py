"""The importer of authored corpora: scenarios and commands written by hand in YAML.

``docs/authored-corpora.md`` describes the files. Read
:mod:`~corpus_tools.importers.authored.authored_files` first: what the files hold, and contexts with
logs. Then read ``authored_corpus``: trees and groundings, whether they fit the log, and random
groundings.
"""
