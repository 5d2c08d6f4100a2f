"""Options of commands that can work on many items at once."""

from __future__ import annotations

import click

JOBS = click.option(
    "--jobs",
    type=click.IntRange(1),
    default=1,
    show_default=True,
    help="How many processes work at the same time.",
)
SCHEDULER = click.option(
    "--scheduler",
    metavar="ADDRESS",
    default="",
    help="Work on a Dask cluster, whose workers see the same files (extra: cluster).",
)
