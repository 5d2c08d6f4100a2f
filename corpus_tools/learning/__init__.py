"""Models that are trained on corpora, and tables of image tags."""
