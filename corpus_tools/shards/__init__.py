"""Features of corpora larger than memory, on disk, and training on them."""
