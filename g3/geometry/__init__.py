"""Geometry of footprints, prisms and trajectories."""
