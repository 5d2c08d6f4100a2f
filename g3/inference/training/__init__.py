"""Examples of the search's own space, which models learn from besides a corpus's own."""
