"""Training of the parser from annotated trees."""
