"""Making many items' files, in this process or in several."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path

from corpus_tools.video.items import Item
from corpus_tools.video.manifest import Settings
from corpus_tools.video.production import OnFrame, produce
from g3.errors import CorpusError


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of an item.

    Parameters
    ----------
    name
        The item's.
    made
        Whether its files were made; else they were there, or it failed.
    problem
        Why it failed; empty if it didn't.
    is_bug
        Whether that is not the input's fault.
    """

    name: str
    made: bool
    problem: str = ""
    is_bug: bool = False


def produce_all(
    items: Iterable[Item],
    out: Path,
    settings: Settings,
    *,
    jobs: int,
    force: bool,
    on_frame: Callable[[str], OnFrame] | None = None,
) -> Iterator[Outcome]:
    """Make all items' folders; one that fails doesn't stop the others.

    Processes are started afresh, because OpenGL doesn't survive a fork, and each makes
    the same files as this one would.

    Parameters
    ----------
    jobs
        How many are made at the same time. With 1 no process is started.
    on_frame
        Given an item's name, tells who is told of its frames; only with one job.
    """
    if jobs == 1:
        for item in items:
            told = on_frame(item.name) if on_frame else None
            yield _outcome(item, out, settings, force, told)
        return
    context = multiprocessing.get_context("spawn")
    threads = os.environ.get("LP_NUM_THREADS")
    # Mesa would start threads for all cores in each process.
    os.environ["LP_NUM_THREADS"] = threads or "1"
    try:
        with ProcessPoolExecutor(jobs, mp_context=context, initializer=_die_silently) as pool:
            futures = {pool.submit(_outcome, item, out, settings, force): item for item in items}
            try:
                yield from (_result(future, futures[future]) for future in as_completed(futures))
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                for process in multiprocessing.active_children():
                    process.terminate()
                raise
    finally:
        if threads is None:
            del os.environ["LP_NUM_THREADS"]


def _die_silently() -> None:
    """Ctrl-C reaches the whole group of processes; only the first one shall speak of it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def _outcome(
    item: Item, out: Path, settings: Settings, force: bool, on_frame: OnFrame | None = None
) -> Outcome:
    try:
        return Outcome(item.name, produce(item, out, settings, force=force, on_frame=on_frame))
    except CorpusError as error:
        return Outcome(item.name, made=False, problem=str(error))
    except OSError as error:
        where = f"{os.fsdecode(error.filename)}: " if error.filename else ""
        return Outcome(item.name, made=False, problem=f"{where}{error.strerror or error}")
    except Exception as error:
        problem = f"unexpected error: {type(error).__name__}: {error}"
        return Outcome(item.name, made=False, problem=problem, is_bug=True)


def _result(future: Future[Outcome], item: Item) -> Outcome:
    try:
        return future.result()
    except BrokenProcessPool:
        problem = "a process ended before its time, perhaps for want of memory (run again)"
        return Outcome(item.name, made=False, problem=problem, is_bug=True)
