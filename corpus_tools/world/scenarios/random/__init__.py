"""Scenarios that nobody wrote: drawn at random and checked like all others."""
