"""The web app in which people type, annotate, ground and rate commands (not built yet)."""
