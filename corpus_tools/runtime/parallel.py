"""One way to work on many items at once: here, in several processes, or on a Dask cluster.

The results are those of working on one item after the other. An item whose process dies is
tried once more, and costs no other item; one whose function raises is not tried again.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from g3.errors import CorpusError
from g3.short_repr import short_repr

if TYPE_CHECKING:
    from distributed import Client

Item = TypeVar("Item")
Result = TypeVar("Result")

ATTEMPTS = 2
"""Number of attempts at an item whose processes die."""
CONNECT_S = 10
LOOK_S = 5.0
"""Time without a result after which a cluster's workers are counted, in seconds."""
WITHOUT_WORKERS_S = 60.0
"""Longest time without workers, in seconds: a dead worker is restarted much sooner."""


@dataclass(frozen=True, slots=True)
class Workers:
    """Processes or cluster that do the work."""

    jobs: int = 1
    """Number of processes on this machine; with 1, none is started."""
    scheduler: str = ""
    """Address of a Dask scheduler, whose workers do it instead; they must have the same packages,
    and see the same files under the same names."""

    def __post_init__(self) -> None:
        if self.jobs < 1:
            raise CorpusError(f"with {self.jobs} jobs nobody works", fix="give 1 or more")


@short_repr
@dataclass(frozen=True, slots=True)
class Done(Generic[Item, Result]):
    """Result or error of an item."""

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
    """Apply a function to each item, and yield results in the order of completion.

    Parameters
    ----------
    function
        Of a module, so that other processes can find it; what it is given and returns must
        be picklable, unless there is one job.
    """
    with Executor(workers) as executor:
        yield from executor.work(function, items)


def work_in_order(
    function: Callable[[Item], Result],
    items: Sequence[Item],
    executor: Executor,
    *,
    on_done: Callable[[int], None] | None = None,
) -> list[Result]:
    """Apply a function to each of some items, and return the results in their order.

    Parameters
    ----------
    on_done
        Called with how many are done.

    Raises
    ------
    Exception
        That of the first item with one, after all were tried.
    """
    items = list(items)
    done: dict[int, Done[Item, Result]] = {}
    for one in executor.work(function, items):
        done[id(one.item)] = one
        if on_done is not None:
            on_done(len(done))
    return [_result(done[id(item)]) for item in items]


def _result(done: Done[Item, Result]) -> Result:
    if done.error is not None:
        raise done.error
    return done.result  # type: ignore[return-value]


class Executor:
    """Processes, or a cluster, kept for several rounds of work; a context manager."""

    def __init__(self, workers: Workers) -> None:
        self._workers = workers
        self._idle: list[ProcessPoolExecutor] = []
        self._client: Client | None = None

    def __enter__(self) -> Executor:
        if self._workers.scheduler:
            self._client = _connect(self._workers.scheduler)
        return self

    def __exit__(self, *_: object) -> None:
        # Waited for: threads that end while the program does complain to its user.
        for process in self._idle:
            process.shutdown(cancel_futures=True)
        self._idle = []
        if self._client is not None:
            self._client.close()

    def work(
        self, function: Callable[[Item], Result], items: Iterable[Item]
    ) -> Iterator[Done[Item, Result]]:
        """Apply a function to each item, as :func:`work` does."""
        if self._client is not None:
            yield from _on_cluster(self._client, function, items)
        elif self._workers.jobs == 1:
            for item in items:
                yield _done(item, lambda item=item: function(item))  # type: ignore[misc]
        else:
            yield from self._in_processes(function, items)

    def _in_processes(
        self, function: Callable[[Item], Result], items: Iterable[Item]
    ) -> Iterator[Done[Item, Result]]:
        """Each process has a pool of its own: one that dies breaks no other."""
        waiting = deque((item, ATTEMPTS) for item in items)
        while len(self._idle) < min(self._workers.jobs, len(waiting)):
            self._idle.append(_new_process())
        busy: dict[Future[Result], tuple[ProcessPoolExecutor, Item, int]] = {}
        try:
            while waiting or busy:
                while self._idle and waiting:
                    item, attempts = waiting.popleft()
                    process = self._idle.pop()
                    busy[process.submit(function, item)] = process, item, attempts - 1
                for future in wait(busy, return_when=FIRST_COMPLETED).done:
                    process, item, attempts = busy.pop(future)
                    done = _done(item, future.result)
                    if not isinstance(done.error, BrokenProcessPool):
                        self._idle.append(process)
                        yield done
                        continue
                    process.shutdown(wait=False)
                    self._idle.append(_new_process())
                    if attempts:
                        waiting.appendleft((item, attempts))
                    else:
                        yield Done(item, error=WorkerDiedError())
        except BaseException:
            for child in multiprocessing.active_children():
                child.terminate()
            raise
        finally:
            for process, _, _ in busy.values():
                process.shutdown(wait=False, cancel_futures=True)


def _done(item: Item, result: Callable[[], Result]) -> Done[Item, Result]:
    try:
        return Done(item, result())
    except Exception as error:
        return Done(item, error=error)


def _new_process() -> ProcessPoolExecutor:
    # Neither OpenGL nor BLAS survives a fork.
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(1, mp_context=context, initializer=_begin)


def _begin() -> None:
    # Ctrl-C reaches the whole group of processes; only the first one shall speak of it.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    # The cores are busy with other processes; NumPy and SciPy read this when they are loaded.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def _connect(address: str) -> Client:
    try:
        import distributed  # noqa: PLC0415 - comes with the extra "cluster"
    except ImportError as error:
        raise CorpusError(
            "a Dask cluster needs a package that isn't installed",
            fix="pip install 'corpus-tools-g3[cluster]'",
        ) from error
    try:
        return distributed.Client(address, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise CorpusError(
            "there is no Dask scheduler", where=address, fix="start one with: dask scheduler"
        ) from error


def _on_cluster(
    client: Client, function: Callable[[Item], Result], items: Iterable[Item]
) -> Iterator[Done[Item, Result]]:
    from distributed.scheduler import (  # noqa: PLC0415 - comes with the extra "cluster"
        KilledWorker,
    )

    killed = []
    for done in _submitted(client, function, items):
        if isinstance(done.error, KilledWorker):
            killed.append(done.item)
        else:
            yield done
    # Dask blames all that a process that died had before it: alone, only the culprit
    # dies again.
    for item in killed:
        for done in _submitted(client, function, [item]):
            died = isinstance(done.error, KilledWorker)
            yield Done(item, error=WorkerDiedError()) if died else done


def _submitted(
    client: Client, function: Callable[[Item], Result], items: Iterable[Item]
) -> Iterator[Done[Item, Result]]:
    """Yield items as they are done. Dask itself retries those whose process died."""
    futures = {client.submit(function, item, pure=False): item for item in items}
    completed: SimpleQueue[Any] = SimpleQueue()
    for future in futures:
        future.add_done_callback(completed.put)
    while futures:
        future = _next(completed, client)
        yield _done(futures.pop(future), future.result)


def _next(completed: SimpleQueue[Any], client: Client) -> Any:
    """Return the next future that is done, as long as the cluster has workers."""
    last_seen = time.monotonic()
    while True:
        try:
            return completed.get(timeout=LOOK_S)
        except Empty:
            if client.scheduler_info()["workers"]:
                last_seen = time.monotonic()
            elif time.monotonic() - last_seen > WITHOUT_WORKERS_S:
                raise CorpusError(
                    "the Dask cluster has had no workers for a while",
                    where=client.scheduler_info()["address"],
                    fix="start some with: dask worker ADDRESS",
                ) from None
