"""Training of the extractor from annotated trees."""
