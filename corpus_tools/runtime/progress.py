"""A progress bar for long work."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

OnProgress = Callable[[str, int, int], None]
"""Called with the step under way, how much of it is done, and how much there is."""


def no_progress(step: str, done: int, total: int) -> None:
    """Show nothing."""


@contextmanager
def progress_bar(first_step: str) -> Iterator[OnProgress]:
    """Show a progress bar on the terminal; nothing where standard error is none.

    `first_step` is what is done until the first report.
    """
    from rich.console import Console  # noqa: PLC0415 - `ct --help` does without
    from rich.progress import Progress  # noqa: PLC0415

    from corpus_tools.runtime.terminal import visible  # noqa: PLC0415

    console = Console(stderr=True)
    if not console.is_terminal:
        yield no_progress
        return
    with Progress(console=console, transient=True) as progress:
        task = progress.add_task(first_step, total=None)
        yield lambda step, done, total: progress.update(
            task, description=visible(step), completed=done, total=total
        )
