"""Attempts in two processes beside the server's: one plans, one carries out and films.

So a plan never waits for a picture or a film. Each process takes one call after the other.
"""

from __future__ import annotations

import multiprocessing
import os
import re
import shutil
import signal
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, ParamSpec, TypeVar, cast

import msgspec
from flask import Flask, current_app

from annotation_app.core.problems import Refusal
from annotation_app.core.random_ids import new_id
from annotation_app.trying.attempt import (
    Actions,
    Asked,
    Shown,
    film,
    first_scenario,
    is_left,
    leave,
    plan,
    prepare,
    read_state,
    warm_up,
    write_state,
)
from annotation_app.trying.start_scene import Scene, read_scene

P = ParamSpec("P")
T = TypeVar("T")
FOLDER, SCENES = "tries", "scenes"
_NAME = "attempts"
LONGEST_QUEUE = 4
KEPT_S = 24 * 3600.0
"""Time for which an attempt can be looked at, in seconds."""
PLANNING_NICENESS, FILMING_NICENESS = 5, 10
"""Plans are short and waited for; the server's processes go before both."""
_ID = re.compile("[0-9a-f]{24}")


def attempts() -> Attempts:
    """Return the attempts of the app that handles this request."""
    return cast("Attempts", current_app.extensions[_NAME])


class _Process:
    """A process that takes one call after the other, and is started when it is needed."""

    def __init__(self, niceness: int, when_started: Callable[[], object]) -> None:
        self._niceness, self._when_started = niceness, when_started
        self._lock = threading.RLock()
        self._pool: ProcessPoolExecutor | None = None
        self._stop: Connection | None = None

    def start(self) -> ProcessPoolExecutor:
        """Start it, unless it runs already."""
        with self._lock:
            if self._pool is None:
                context = multiprocessing.get_context("spawn")  # OpenGL doesn't survive a fork
                ended, self._stop = context.Pipe(duplex=False)
                self._pool = ProcessPoolExecutor(
                    1, mp_context=context, initializer=_begin, initargs=(ended, self._niceness)
                )
                self._when_started()
            return self._pool

    def submit(self, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Have it call a function; where it has died, another one does."""
        with self._lock:
            try:
                future = self.start().submit(function, *args, **kwargs)
            except BrokenProcessPool:
                self._pool = None
                future = self.start().submit(function, *args, **kwargs)
            pool = self._pool
        future.add_done_callback(lambda done: self._forget_dead(pool, done))
        return future

    def _forget_dead(self, pool: ProcessPoolExecutor | None, done: Future[Any]) -> None:
        """Start another process next time if that of a call has died."""
        if not done.cancelled() and done.exception() is not None:
            with self._lock:
                if self._pool is pool:
                    self._pool = None

    def close(self) -> None:
        """End the process after the call that is under way."""
        with self._lock:
            pool, self._pool = self._pool, None
        if pool is not None:
            pool.shutdown(cancel_futures=True)

    def stop(self) -> None:
        """End the process at once."""
        if self._stop is not None:
            self._stop.close()
        self.close()


class Attempts:
    """The attempts of an installation.

    Attempts are files, so that any server process can show what another one's has made. The model
    that follows commands is the bundled one if there is none.
    """

    def __init__(self, instance: Path, model: Path | None) -> None:
        self.folder = instance / FOLDER
        self.model = model
        self._lock = threading.RLock()
        self._waiting: dict[str, Future[Any]] = {}
        self._prepared: dict[str, Future[None]] = {}
        self._planning = _Process(
            PLANNING_NICENESS, lambda: self._planning.submit(warm_up, self.model)
        )
        self._filming = _Process(FILMING_NICENESS, self._prepared.clear)

    def install(self, app: Flask) -> None:
        """Give them to an app."""
        app.extensions[_NAME] = self

    def submit(self, asked: Asked) -> str:
        """Begin an attempt, unless too many others wait; return its id, which can't be guessed."""
        with self._lock:
            self._waiting = {n: f for n, f in self._waiting.items() if not f.done()}
            if len(self._waiting) >= LONGEST_QUEUE:
                raise Refusal(429, "Others are trying commands. Wait a minute and try again.")
            self._forget()
            name = new_id()
            folder = self.folder / name
            folder.mkdir(parents=True)
            write_state(folder, Shown(asked))
            future = self._planning.submit(plan, folder, self.model)
            self._waiting[name] = future
            future.add_done_callback(lambda done: self._planned(folder, done))
            return name

    def leave(self, name: str) -> None:
        """Make no video of an attempt whose plan somebody has seen, and who tries another one."""
        with self._lock:
            if _ID.fullmatch(name) and (self.folder / name).is_dir():
                leave(self.folder / name)
                self._waiting.pop(name, None)

    def warm_up(self) -> None:
        """Get the processes ready for the first command, in the background."""
        self._planning.start()
        self.scene(first_scenario())

    def scene(self, scenario: str) -> Scene | None:
        """Return a scenario's scene; None while it is made, which this begins."""
        folder = self.scene_folder(scenario)
        found = read_scene(folder)
        with self._lock:
            self._filming.start()
            if scenario not in self._prepared or (
                found is None and self._prepared[scenario].done()
            ):
                self._prepared[scenario] = self._filming.submit(prepare, folder, scenario)
        return found

    def scene_folder(self, scenario: str) -> Path:
        """Return the folder of a scenario's scene."""
        return self.folder / SCENES / scenario

    def state(self, name: str) -> Shown | None:
        """Return the progress of an attempt; None if there is no such attempt."""
        return read_state(self.folder / name) if _ID.fullmatch(name) else None

    def close(self) -> None:
        """End the processes after what is under way; planning first, as films follow plans."""
        self._planning.close()
        self._filming.close()

    def stop(self) -> None:
        """End the processes at once; viewers of their attempts get a message."""
        self._planning.stop()
        self._filming.stop()

    def _planned(self, folder: Path, done: Future[Actions | None]) -> None:
        """Have a plan carried out and filmed; report an attempt whose process has died."""
        if done.cancelled() or done.exception() is not None:
            self._report_end(folder)
        elif (actions := done.result()) is not None:
            with self._lock:
                future = self._filming.submit(film, folder, actions)
                if not is_left(folder):
                    self._waiting[folder.name] = future
            future.add_done_callback(lambda done: self._filmed(folder, done))

    def _filmed(self, folder: Path, done: Future[None]) -> None:
        if done.cancelled() or done.exception() is not None:
            self._report_end(folder)

    def _report_end(self, folder: Path) -> None:
        shown = read_state(folder)
        if shown is not None:
            problem = "This took too much memory, or the server was stopped. Try again."
            write_state(folder, msgspec.structs.replace(shown, phase="done", problem=problem))

    def _forget(self) -> None:
        for folder in self.folder.glob("*"):
            if _ID.fullmatch(folder.name) and time.time() - folder.stat().st_mtime > KEPT_S:
                shutil.rmtree(folder, ignore_errors=True)


def _begin(ended: Connection, niceness: int) -> None:
    """Let the server's processes go first, and end with the process that started this one."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C reaches the whole group of processes
    if hasattr(os, "nice"):  # there is none on Windows
        os.nice(niceness)
    os.environ["LP_NUM_THREADS"] = "1"  # Mesa would start threads for all cores
    threading.Thread(target=_end_with, args=(ended,), daemon=True).start()


def _end_with(ended: Connection) -> None:
    ended.poll(None)  # until the other end is closed, by whatever end the server has come to
    os._exit(0)
