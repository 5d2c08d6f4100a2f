"""A study's file: what is asked of whom."""
