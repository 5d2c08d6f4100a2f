"""Figures with their intervals: bootstrap, rating models, comparisons, power."""
