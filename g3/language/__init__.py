"""Words: the lexicon, words against labels, discourse, and from text to SDC trees.

Imports run one way: ``lexicon`` ← ``similarity``; ``discourse``; ``parsing`` ←
``parsing.training``.
"""
