"""Foundations of the app: configuration, keys, ids, refusals."""
