"""Copies of all rows and of media: written, checked and restored."""
