"""Erasing a person's data, and what goes when a study is over."""
