"""A language model at an endpoint of yours, as a grounder, as a parser and as a judge."""
