"""``ct annotate people``: who may sign in, as what, and whose data are kept."""

from __future__ import annotations

import click


@click.group()
def people() -> None:
    """Manage the people who sign in, and erase anybody's data.

    \b
    Examples:
      ct annotate people invite --role annotator
      ct annotate people list
      ct annotate people reset maria
    """
