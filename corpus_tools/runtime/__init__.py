"""Processes, progress, whole folders and safe output, for long and careful work."""
