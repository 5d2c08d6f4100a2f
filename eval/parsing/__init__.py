"""``ct eval --sdc``: how well clauses are extracted from text."""
