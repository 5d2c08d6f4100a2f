"""Measures models and corpora: the paper's tables, intervals, curves and error lists.

Read :mod:`eval.table_1.correspondence` first.
"""
