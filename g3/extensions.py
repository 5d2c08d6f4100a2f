"""Modules of other distributions that add to a registry.

A registry that others may add to has an entry point group, and loads it after its own members:
whoever sees the registry sees the others' members too, in worker processes as well. Each entry
point names a module; importing it registers what it has.
"""

from __future__ import annotations

import importlib.metadata
import logging


def load_extensions(group: str) -> None:
    """Import the modules that installed distributions name in an entry point group.

    One that can't be imported is told in the log and stops no other.
    """
    for point in sorted(importlib.metadata.entry_points(group=group), key=lambda p: p.name):
        try:
            point.load()
        except Exception as error:  # whatever it is, the rest must go on working
            logging.getLogger(__name__).warning(
                "%s: the extension %s can't be loaded: %s: %s",
                group,
                point.name,
                type(error).__name__,
                error,
            )
