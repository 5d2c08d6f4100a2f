"""What a new study gets: from rendered videos, from a corpus, or for a look."""
