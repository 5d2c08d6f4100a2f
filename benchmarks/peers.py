"""The annotation app against Potato and Label Studio: ``python -m benchmarks.peers``.

Both are installed into environments of their own, which are kept. One server process of each is
driven by the same client: 50 workers open an item, rate it and open the next, as fast as it goes. A
peer that can't be installed or started here is named and left out.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from benchmarks.peer_programs import PEERS, Client, LabelStudio, Ours, Potato, Program
from benchmarks.timing import row
from tests.annotation_app.load_servers import free_port

PATIENCE_S = 300.0
INSTALL_S = 1200


def installed(package: str, folder: Path) -> Path:
    """Return the Python of an environment that has a package; make it where it is missing."""
    python = folder / package / "bin" / "python"
    done = folder / package / "installed"
    if not done.exists():
        print(f"  installing {package}", flush=True)
        subprocess.run([sys.executable, "-m", "venv", "--clear", folder / package], check=True)
        subprocess.run(
            [python, "-m", "pip", "install", "--quiet", package],
            check=True,
            stderr=subprocess.DEVNULL,
            timeout=INSTALL_S,
        )
        done.touch()
    return python


@contextlib.contextmanager
def running(program: Program, folder: Path) -> Iterator[tuple[int, float]]:
    """Start a server; yield its port, and the seconds until its first page."""
    port = free_port()
    start = time.perf_counter()
    with (folder / "output.txt").open("wb") as output:
        process = subprocess.Popen(
            program.command(folder, port),
            cwd=folder,
            env={**os.environ, **program.surroundings(folder)},
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
    try:
        while not _answers(port):
            if process.poll() is not None or time.perf_counter() - start > PATIENCE_S:
                last = (folder / "output.txt").read_text(errors="replace").splitlines()[-1:]
                raise OSError(f"it doesn't start: {''.join(last)}")
            time.sleep(0.05)
        yield port, time.perf_counter() - start
    finally:
        os.killpg(process.pid, signal.SIGKILL)  # with the processes that it has started
        process.wait()


def _answers(port: int) -> bool:
    client = Client(port)
    try:
        return client.send_once("GET", "/").status < 500
    except OSError:
        return False
    finally:
        client.connection.close()


def drive(program: Program, port: int, workers: int, each: int) -> str:
    """Let workers do items at once; return the answers a second, their time and the errors."""
    clients = [Client(port) for _ in range(workers)]
    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(program.sign_in, clients, range(workers)))
        answered: list[float] = []

        def work(number: int) -> None:
            for turn in range(each):
                item = program.open(clients[number], number, turn)
                begin = time.perf_counter()
                program.answer(clients[number], item)
                answered.append(time.perf_counter() - begin)

        start = time.perf_counter()
        list(pool.map(work, range(workers)))
        wall_s = time.perf_counter() - start
    errors = sum(client.refused for client in clients)
    for client in clients:
        client.connection.close()
    p95 = 1000 * np.percentile(answered, 95)
    return f"{len(answered) / wall_s:.0f} answers/s, p95 {p95:.0f} ms, {errors} errors"


def measure(program: Program, workers: int, each: int) -> None:
    """Measure a program, and add its row to the table."""
    with tempfile.TemporaryDirectory() as name, running(program, Path(name)) as (port, start_s):
        program.fill(port, workers, each)
        done = drive(program, port, workers, each)
    row(f"{workers} workers, one process: {program.name}", f"{done}; first page {start_s:.1f} s")


def made(kind: type[Ours | Potato | LabelStudio], folder: Path) -> Program:
    """Return a program, installed if it isn't ours."""
    return Ours() if issubclass(kind, Ours) else kind(installed(kind.package, folder))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, prog="python -m benchmarks.peers")
    parser.add_argument("--workers", type=int, default=50)
    parser.add_argument("--each", type=int, default=8, help="answers of a worker (8)")
    parser.add_argument("--only", default="", metavar="TEXT", help="programs whose name has this")
    parser.add_argument("--folder", default="benchmark-data/peers", help="environments")
    given = parser.parse_args()
    missing = []
    for kind in (Ours, *PEERS):
        if given.only.lower() in kind.name.lower():
            try:
                program = made(kind, Path(given.folder).resolve())
                measure(program, given.workers, given.each)
            except (OSError, subprocess.SubprocessError, AssertionError) as error:
                missing.append(f"{kind.name}: left out: {error}")
    print("", *missing, sep="\n")


if __name__ == "__main__":
    main()
