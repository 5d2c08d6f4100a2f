"""Shared parts of pages and programs: the interface in JSON and its limits."""
