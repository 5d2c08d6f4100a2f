"""``ct annotate people``: who may sign in, as what, and whose data are kept."""

from __future__ import annotations

import click

from annotation_app.erasure_commands import erase


@click.group()
def people() -> None:
    """Add, invite, list, block and reset people who sign in; erase anybody's data.

    \b
    Examples:
      ct annotate people invite --role annotator
      ct annotate people list
      ct annotate people reset maria
    """


people.add_command(erase)
