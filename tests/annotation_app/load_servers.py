"""Servers of the annotation app that can be killed and started again."""

from __future__ import annotations

import contextlib
import itertools
import os
import random
import signal
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from annotation_app.core.config import Config
from tests.annotation_app.conftest import new_database
from tests.annotation_app.postgres import cluster

PATIENCE_S = 60.0
TICKS_PER_S = os.sysconf("SC_CLK_TCK")
CT = ("-m", "corpus_tools")
"""Python's arguments to run ``ct``."""


def free_port() -> int:
    """Return a port that no connection gets by chance while its server is down."""
    for port in random.SystemRandom().sample(range(15_000, 30_000), 100):
        with socket.socket() as probe, contextlib.suppress(OSError):
            probe.bind(("127.0.0.1", port))
            return port
    raise OSError("no port is free")


class Server:
    """A process of ``ct annotate`` that can be killed and started again."""

    def __init__(self, config: Config, threads: int) -> None:
        self.config = config
        self.threads = threads
        self.port = free_port()
        self.process = self._start()

    @property
    def address(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def _start(self) -> subprocess.Popen[bytes]:
        command = [sys.executable, *CT, "annotate", "serve"]
        options = ["--instance", str(self.config.instance), "--port", str(self.port)]
        options += ["--database", str(self.config.database), "--threads", str(self.threads)]
        return subprocess.Popen([*command, *options], stdout=subprocess.DEVNULL)

    def wait(self) -> None:
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            with contextlib.suppress(OSError):
                urllib.request.urlopen(f"{self.address}/api/session", timeout=5).close()
                return
            time.sleep(0.1)
        raise TimeoutError(f"no server at {self.address}")

    def kill_and_restart(self) -> None:
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()
        self.process = self._start()

    def stop(self) -> None:
        self.process.kill()
        self.process.wait()


@contextlib.contextmanager
def servers(config: Config, count: int, threads: int) -> Iterator[list[Server]]:
    running = [Server(config, threads) for _ in range(count)]
    try:
        for server in running:
            server.wait()
        yield running
    finally:
        for server in running:
            server.stop()


@contextlib.contextmanager
def new_databases(kind: str) -> Iterator[Callable[[], str]]:
    """Yield a function that makes SQLite's or PostgreSQL's databases and returns their URLs."""
    if kind == "sqlite":
        numbers = itertools.count()
        with tempfile.TemporaryDirectory() as folder:
            yield lambda: f"sqlite:///{folder}/{next(numbers)}.sqlite"
        return
    with cluster(durable=True) as url:
        yield lambda: new_database(url)


class Process(NamedTuple):
    """A process of this machine, and its processor time so far."""

    id: int
    name: str
    parent: int
    seconds: float


def processes() -> Iterator[Process]:
    """Yield all processes of the machine."""
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):  # it has ended
            name, _, rest = stat.read_text().partition(" (")[2].rpartition(") ")
            fields = rest.split()
            seconds = (int(fields[11]) + int(fields[12])) / TICKS_PER_S
            yield Process(int(stat.parent.name), name, int(fields[1]), seconds)


def processor_s() -> dict[str, float]:
    """Return processor times so far of the servers, of PostgreSQL and of this process."""
    found = {"servers": 0.0, "database": 0.0, "workers": time.process_time()}
    for one in processes():
        if one.name == "postgres":
            found["database"] += one.seconds
        elif one.parent == os.getpid():
            found["servers"] += one.seconds
    return found
