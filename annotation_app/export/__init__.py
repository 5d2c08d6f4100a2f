"""From answers to a corpus and to tables."""
