"""From labelled factors to a model: examples, the CRF's likelihood, optimisers, weights."""
