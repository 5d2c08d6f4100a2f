"""Options of commands that can work on many items at once."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import click

from corpus_tools.options.format_option import with_default


def WORKERS(command: Callable[..., Any]) -> Callable[..., Any]:  # noqa: N802 - as options are
    """Add ``--jobs`` and ``--scheduler``; the command gets both as ``workers``."""

    @with_default(
        "--jobs",
        type=click.IntRange(1),
        default=1,
        help="How many processes work at the same time.",
    )
    @click.option(
        "--scheduler",
        metavar="ADDRESS",
        default="",
        help="Work on a Dask cluster, whose workers see the same files (extra: cluster).",
    )
    @functools.wraps(command)
    def with_workers(*args: Any, jobs: int, scheduler: str, **options: Any) -> Any:
        from corpus_tools.runtime.parallel import Workers  # noqa: PLC0415 - `ct --help` does without

        return command(*args, workers=Workers(jobs, scheduler), **options)

    return with_workers
