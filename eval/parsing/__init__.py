"""``ct eval sdc``: accuracy of clauses extracted from text."""
