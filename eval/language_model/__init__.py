"""A language model at an endpoint of yours, as a grounder and as a judge of Table 3."""
