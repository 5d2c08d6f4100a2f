"""One attempt after the other, in one process beside the server's."""

from __future__ import annotations

import multiprocessing
import os
import re
import shutil
import signal
import threading
import time
from concurrent.futures import Future, ProcessPoolExecutor
from multiprocessing.connection import Connection
from pathlib import Path
from typing import cast

from flask import Flask, current_app

from annotation_app.core.problems import Refusal
from annotation_app.core.random_ids import new_id
from annotation_app.trying.attempt import (
    Asked,
    Shown,
    attempt,
    prepare,
    read_state,
    warm_up,
    write_state,
)
from annotation_app.trying.start_scene import Scene, read_scene

FOLDER, SCENES = "tries", "scenes"
_NAME = "attempts"
LONGEST_QUEUE = 4
KEPT_S = 24 * 3600.0
"""Time for which an attempt can be looked at, in seconds."""
NICENESS = 10
_ID = re.compile("[0-9a-f]{24}")


def attempts() -> Attempts:
    """Return the attempts of the app that handles this request."""
    return cast("Attempts", current_app.extensions[_NAME])


class Attempts:
    """The attempts of an installation, which a process follows one by one.

    Attempts are files, so that any server process can show what another one's has made. The model
    that follows commands is the bundled one if there is none.
    """

    def __init__(self, instance: Path, model: Path | None) -> None:
        self.folder = instance / FOLDER
        self.model = model
        self._lock = threading.RLock()
        self._pool: ProcessPoolExecutor | None = None
        self._stop: Connection | None = None
        self._waiting: list[Future[None]] = []
        self._prepared: dict[str, Future[None]] = {}

    def install(self, app: Flask) -> None:
        """Give them to an app."""
        app.extensions[_NAME] = self

    def submit(self, asked: Asked) -> str:
        """Begin an attempt, unless too many others wait; return its id, which can't be guessed."""
        with self._lock:
            self._waiting = [future for future in self._waiting if not future.done()]
            if len(self._waiting) >= LONGEST_QUEUE:
                raise Refusal(429, "Others are trying commands. Wait a minute and try again.")
            self._forget()
            name = new_id()
            folder = self.folder / name
            folder.mkdir(parents=True)
            write_state(folder, Shown(asked))
            future = self._process().submit(attempt, folder, self.model)
            future.add_done_callback(lambda done: self._ended(folder, done))
            self._waiting.append(future)
            return name

    def warm_up(self) -> None:
        """Get the process ready for the first command, in the background."""
        with self._lock:
            self._process()

    def scene(self, scenario: str) -> Scene | None:
        """Return a scenario's scene; None while it is made, which this begins."""
        folder = self.scene_folder(scenario)
        found = read_scene(folder)
        with self._lock:
            if scenario not in self._prepared or (
                found is None and self._prepared[scenario].done()
            ):
                future = self._process().submit(prepare, folder, scenario)
                future.add_done_callback(self._lost)
                self._prepared[scenario] = future
        return found

    def scene_folder(self, scenario: str) -> Path:
        """Return the folder of a scenario's scene."""
        return self.folder / SCENES / scenario

    def _process(self) -> ProcessPoolExecutor:
        if self._pool is None:
            context = multiprocessing.get_context("spawn")  # OpenGL doesn't survive a fork
            ended, self._stop = context.Pipe(duplex=False)
            self._pool = ProcessPoolExecutor(
                1, mp_context=context, initializer=_begin, initargs=(ended,)
            )
            self._prepared.clear()
            self._pool.submit(warm_up, self.model).add_done_callback(self._lost)
        return self._pool

    def state(self, name: str) -> Shown | None:
        """Return the progress of an attempt; None if there is no such attempt."""
        return read_state(self.folder / name) if _ID.fullmatch(name) else None

    def close(self) -> None:
        """End the process, after the attempt that is under way."""
        with self._lock:
            pool, self._pool = self._pool, None
        if pool is not None:
            pool.shutdown(cancel_futures=True)

    def stop(self) -> None:
        """End the process at once; viewers of its attempt get a message."""
        if self._stop is not None:
            self._stop.close()
        self.close()

    def _ended(self, folder: Path, done: Future[None]) -> None:
        """Report an attempt whose process has died."""
        if not self._lost(done):
            return
        shown = read_state(folder)
        if shown is not None:
            problem = "This took too much memory, or the server was stopped. Try again."
            write_state(folder, Shown(shown.asked, "done", problem=problem))

    def _lost(self, done: Future[None]) -> bool:
        """Check that a process has died, and then start another one next time."""
        if done.cancelled() or done.exception() is None:
            return False
        with self._lock:
            self._pool = None
        return True

    def _forget(self) -> None:
        for folder in self.folder.glob("*"):
            if _ID.fullmatch(folder.name) and time.time() - folder.stat().st_mtime > KEPT_S:
                shutil.rmtree(folder, ignore_errors=True)


def _begin(ended: Connection) -> None:
    """Let the server's processes go first, and end with the process that started this one."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C reaches the whole group of processes
    if hasattr(os, "nice"):  # there is none on Windows
        os.nice(NICENESS)
    os.environ["LP_NUM_THREADS"] = "1"  # Mesa would start threads for all cores
    threading.Thread(target=_end_with, args=(ended,), daemon=True).start()


def _end_with(ended: Connection) -> None:
    ended.poll(None)  # until the other end is closed, by whatever end the server has come to
    os._exit(0)
