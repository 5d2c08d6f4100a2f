"""Export of answers as a corpus and as tables."""
