"""Servers of the annotation app that can be killed and started again."""

from __future__ import annotations

import contextlib
import os
import random
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator, Sequence
from pathlib import Path

from annotation_app.core.config import Config

PATIENCE_S = 60.0
TICKS_PER_S = os.sysconf("SC_CLK_TCK")
CT = ("-m", "corpus_tools")
"""What Python is given to run ``ct``."""


def free_port() -> int:
    """A port that no connection gets by chance while its server is down."""
    for port in random.SystemRandom().sample(range(15_000, 30_000), 100):
        with socket.socket() as probe, contextlib.suppress(OSError):
            probe.bind(("127.0.0.1", port))
            return port
    raise OSError("no port is free")


class Server:
    """A process of ``ct annotate`` that can be killed and started again."""

    def __init__(self, config: Config, threads: int, program: Sequence[str] = CT) -> None:
        self.config = config
        self.program = program
        self.threads = threads
        self.port = free_port()
        self.process = self._start()

    @property
    def address(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def _start(self) -> subprocess.Popen[bytes]:
        command = [sys.executable, *self.program, "annotate", "serve"]
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
def servers(
    config: Config, count: int, threads: int, program: Sequence[str] = CT
) -> Iterator[list[Server]]:
    running = [Server(config, threads, program) for _ in range(count)]
    try:
        for server in running:
            server.wait()
        yield running
    finally:
        for server in running:
            server.stop()


def processor_s() -> dict[str, float]:
    """Processor time so far of the servers, of PostgreSQL and of this process."""
    found = {"servers": 0.0, "database": 0.0, "workers": time.process_time()}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            name, _, rest = stat.read_text().partition(" (")[2].rpartition(") ")
        except OSError:  # it has ended
            continue
        fields = rest.split()
        seconds = (int(fields[11]) + int(fields[12])) / TICKS_PER_S
        if int(fields[1]) == os.getpid() and name != "postgres":
            found["servers"] += seconds
        elif name == "postgres":
            found["database"] += seconds
    return found
