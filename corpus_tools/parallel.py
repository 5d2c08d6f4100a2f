"""One way to work on many items at once: here, in several processes, or on a Dask cluster.

The results are those of working on one item after the other. An item whose process dies is
tried once more, and costs no other item; one whose function raises is not tried again.
"""

from __future__ import annotations

import multiprocessing
import signal
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, TypeVar

from g3.errors import CorpusError

if TYPE_CHECKING:
    from distributed import Client

Item = TypeVar("Item")
Result = TypeVar("Result")

ATTEMPTS = 2
"""How often an item is begun whose processes die."""
CONNECT_S = 10


@dataclass(frozen=True, slots=True)
class Workers:
    """Where work is done.

    Parameters
    ----------
    jobs
        How many processes there are on this machine; with 1, none is started.
    scheduler
        Address of a Dask scheduler, whose workers do it instead; they must have the same
        packages, and see the same files under the same names.
    """

    jobs: int = 1
    scheduler: str = ""


@dataclass(frozen=True, slots=True)
class Done(Generic[Item, Result]):
    """What came of an item: a result, or an error."""

    item: Item
    result: Result | None = None
    error: Exception | None = None


class WorkerDiedError(Exception):
    """The processes that worked on an item ended before it was done."""

    def __init__(self) -> None:
        super().__init__("its processes ended before their time, perhaps for want of memory")


def work(
    function: Callable[[Item], Result], items: Iterable[Item], workers: Workers
) -> Iterator[Done[Item, Result]]:
    """Apply a function to each item; what is done first comes first.

    Parameters
    ----------
    function
        Of a module, so that other processes can find it; what it is given and returns must
        be picklable, unless there is one job.

    Raises
    ------
    CorpusError
        If the cluster can't be reached, or the package for it is missing.
    """
    if workers.scheduler:
        yield from _on_cluster(function, items, workers.scheduler)
    elif workers.jobs == 1:
        for item in items:
            yield _done(item, lambda item=item: function(item))  # type: ignore[misc]
    else:
        yield from _in_processes(function, deque(items), workers.jobs)


def _done(item: Item, result: Callable[[], Result]) -> Done[Item, Result]:
    try:
        return Done(item, result())
    except Exception as error:
        return Done(item, error=error)


def _in_processes(
    function: Callable[[Item], Result], items: deque[Item], jobs: int
) -> Iterator[Done[Item, Result]]:
    """Each process has a pool of its own: one that dies breaks no other."""
    waiting = deque((item, ATTEMPTS) for item in items)
    idle = [_new_process() for _ in range(min(jobs, len(waiting)))]
    busy: dict[Future[Result], tuple[ProcessPoolExecutor, Item, int]] = {}
    try:
        while waiting or busy:
            while idle and waiting:
                item, attempts = waiting.popleft()
                process = idle.pop()
                busy[process.submit(function, item)] = process, item, attempts - 1
            for future in wait(busy, return_when=FIRST_COMPLETED).done:
                process, item, attempts = busy.pop(future)
                done = _done(item, future.result)
                if not isinstance(done.error, BrokenProcessPool):
                    idle.append(process)
                    yield done
                    continue
                process.shutdown(wait=False)
                idle.append(_new_process())
                if attempts:
                    waiting.appendleft((item, attempts))
                else:
                    yield Done(item, error=WorkerDiedError())
    except BaseException:
        for child in multiprocessing.active_children():
            child.terminate()
        raise
    finally:
        for process in (*idle, *(process for process, _, _ in busy.values())):
            process.shutdown(wait=False, cancel_futures=True)


def _new_process() -> ProcessPoolExecutor:
    # Neither OpenGL nor BLAS survives a fork.
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(1, mp_context=context, initializer=_die_silently)


def _die_silently() -> None:
    """Ctrl-C reaches the whole group of processes; only the first one shall speak of it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def _on_cluster(
    function: Callable[[Item], Result], items: Iterable[Item], address: str
) -> Iterator[Done[Item, Result]]:
    try:
        import distributed  # noqa: PLC0415 - comes with the extra "cluster"
    except ImportError as error:
        raise CorpusError(
            "a Dask cluster needs a package that isn't installed",
            fix="pip install 'corpus-tools-g3[cluster]'",
        ) from error
    try:
        client = distributed.Client(address, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise CorpusError(
            "there is no Dask scheduler", where=address, fix="start one with: dask scheduler"
        ) from error
    with client:
        killed = []
        for done in _submitted(client, function, items):
            if isinstance(done.error, distributed.scheduler.KilledWorker):
                killed.append(done.item)
            else:
                yield done
        # Dask blames whatever a process that died had before it: alone, only the culprit
        # dies again.
        for item in killed:
            for done in _submitted(client, function, [item]):
                died = isinstance(done.error, distributed.scheduler.KilledWorker)
                yield Done(item, error=WorkerDiedError()) if died else done


def _submitted(
    client: Client, function: Callable[[Item], Result], items: Iterable[Item]
) -> Iterator[Done[Item, Result]]:
    """What dies is begun anew elsewhere by Dask itself."""
    from distributed import as_completed  # noqa: PLC0415 - comes with the extra "cluster"

    futures = {client.submit(function, item, pure=False): item for item in items}
    for future in as_completed(list(futures), loop=client.loop):
        yield _done(futures.pop(future), future.result)
