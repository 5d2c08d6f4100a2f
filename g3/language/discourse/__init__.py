"""Pronouns, negation and plurals within a command."""
