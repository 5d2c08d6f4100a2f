"""Likelihood that a word denotes a label of the semantic map (section 3.3)."""
