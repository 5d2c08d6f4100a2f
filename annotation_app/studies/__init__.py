"""A study's file: its tasks and its people."""
