"""Contents of a new study: from rendered videos, from a corpus, or for a demo."""
