"""``ct log``: look at logs of worlds."""

from __future__ import annotations

from pathlib import Path

import click

from corpus_tools.options import FORMAT, ExistingPath, tell


@click.group()
def log() -> None:
    """Look at logs: what happened in a world, as MCAP files.

    \b
    Example:
      ct log show out/pick_up_tires.mcap
    """


@log.command()
@click.argument("path", metavar="FILE", type=ExistingPath("`ct render-videos` makes logs"))
@FORMAT
def show(path: Path, form: str) -> None:
    """Show what a log holds: its scenario, objects and steps.

    \b
    Examples:
      ct log show out/pick_up_tires.mcap
      ct log show out/pick_up_tires.mcap --json
    """
    from corpus_tools.logs.log_reading import as_table, read_log, summary

    held = summary(read_log(path))
    tell(form, held, as_table(held))
