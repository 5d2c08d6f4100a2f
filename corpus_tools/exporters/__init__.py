"""Writing corpora in the formats of others."""
