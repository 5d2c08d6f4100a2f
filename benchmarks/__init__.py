"""Measurements of speed, as ratios within one process; see README.md."""
