"""A grounder, a parser and a judge that the toolkit does not have."""
