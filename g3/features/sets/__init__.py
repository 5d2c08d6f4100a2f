"""The feature sets, a family in each module."""
