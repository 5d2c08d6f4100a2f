"""Making many items' files, in this process or in several."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from corpus_tools.runtime.parallel import Done, WorkerDiedError, Workers, work
from corpus_tools.video.drawing.gl import VARIABLE, choose_back_end
from corpus_tools.video.items import Item
from corpus_tools.video.manifest import Settings
from corpus_tools.video.production import OnFrameCount, produce
from g3.errors import CorpusError
from g3.storage.system_errors import named_error

THREADS = "LP_NUM_THREADS"
"""Number of threads that Mesa starts in a process; it would start them for all cores in each."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """Result of rendering an item."""

    name: str
    made: bool
    """True if its files were made; else they were there, or it failed."""
    problem: str = ""
    """Reason why it failed; empty if it didn't."""
    is_bug: bool = False
    """True if the input is not to blame."""


def produce_all(
    items: Iterable[Item],
    out: Path,
    settings: Settings,
    *,
    workers: Workers,
    force: bool,
    on_frame: Callable[[str], OnFrameCount] | None = None,
) -> Iterator[Outcome]:
    """Make all items' folders; one that fails doesn't stop the others.

    Each process of the workers makes the same files as this one would. `on_frame` gives for an
    item's name what to call with its frames; only with one job.
    """
    if workers == Workers():
        for item in items:
            told = on_frame(item.name) if on_frame else None
            yield _outcome(item, out=out, settings=settings, force=force, on_frame=told)
        return
    make = partial(_outcome_elsewhere, out=out.absolute(), settings=settings, force=force)
    yield from map(_told, work(make, items, workers))


def _outcome_elsewhere(item: Item, *, out: Path, settings: Settings, force: bool) -> Outcome:
    os.environ.setdefault(THREADS, "1")
    if VARIABLE not in os.environ:
        choose_back_end()
    return _outcome(item, out=out, settings=settings, force=force)


def _outcome(
    item: Item, *, out: Path, settings: Settings, force: bool, on_frame: OnFrameCount | None = None
) -> Outcome:
    try:
        return Outcome(item.name, produce(item, out, settings, force=force, on_frame=on_frame))
    except CorpusError as error:
        return Outcome(item.name, made=False, problem=str(error))
    except Exception as error:
        named = named_error(error) if isinstance(error, OSError) else None
        if named is not None:
            return Outcome(item.name, made=False, problem=str(named))
        problem = f"unexpected error: {type(error).__name__}: {error}"
        return Outcome(item.name, made=False, problem=problem, is_bug=True)


def _told(done: Done[Item, Outcome]) -> Outcome:
    if done.result is not None:
        return done.result
    again = " (run again)" if isinstance(done.error, WorkerDiedError) else ""
    return Outcome(done.item.name, made=False, problem=f"{done.error}{again}", is_bug=True)
