"""The annotation app against Potato and Label Studio: ``python -m benchmarks.peers``.

Both are installed into environments of their own, which are kept. One server process of each is
driven by the same client: 50 workers open an item, rate it and open the next, first as fast as it
goes, then with time to think. A peer that can't be installed or started here is named and left out.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.app_servers import free_port, processes
from benchmarks.peer_programs import PEERS, Client, LabelStudio, Ours, Potato, Program
from benchmarks.timing import row

PATIENCE_S = 300.0
INSTALL_S = 1200


@dataclass(frozen=True)
class Figures:
    """Answers a second, milliseconds of an answer, errors of the server."""

    per_s: float
    answer_p50: float
    answer_p95: float
    processor_ms: float
    refused: int


def installed(package: str, folder: Path) -> Path:
    """Return the Python of an environment that has a package; make it where it is missing.

    Raises
    ------
    subprocess.SubprocessError
        If it can't be installed.
    """
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
def running(program: Program, folder: Path) -> Iterator[tuple[int, float, subprocess.Popen[bytes]]]:
    """Start a server; yield its port, the seconds until its first page, and its process."""
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
        yield port, time.perf_counter() - start, process
    finally:
        os.killpg(process.pid, signal.SIGKILL)  # with the processes that it has started
        process.wait()


def _answers(port: int) -> bool:
    client = Client(port)
    try:
        return client.send("GET", "/").status < 500
    except OSError:
        return False
    finally:
        client.close()


def drive(
    program: Program, server: tuple[int, int], workers: int, each: int, think_s: float
) -> Figures:
    """Let workers do items at once, on a server with this port and process."""
    port, process = server
    clients = [Client(port) for _ in range(workers)]
    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(program.sign_in, clients, range(workers)))
        answered: list[float] = []

        def work(number: int) -> None:
            luck = random.Random(number)
            for i in range(each):
                if think_s:
                    time.sleep(luck.expovariate(1 / think_s))
                item = program.open(clients[number], number, i)
                if think_s:
                    time.sleep(luck.expovariate(1 / think_s))
                begin = time.perf_counter()
                program.answer(clients[number], item)
                answered.append(time.perf_counter() - begin)

        before, start = processor_s(process), time.perf_counter()
        list(pool.map(work, range(workers)))
        wall_s = time.perf_counter() - start
    refused = sum(client.refused for client in clients)
    for client in clients:
        client.close()
    p50, p95 = 1000 * np.percentile(answered, [50, 95])
    taken = 1000 * (processor_s(process) - before) / len(answered)
    return Figures(len(answered) / wall_s, p50, p95, taken, refused)


def processor_s(process: int) -> float:
    """Return the processor time so far of a process and of all processes that it has started."""
    there = {one.id: one for one in processes()}

    def belongs(pid: int) -> bool:
        return pid == process or (pid in there and belongs(there[pid].parent))

    return sum(one.seconds for pid, one in there.items() if belongs(pid))


def measure(program: Program, workers: int, each: int, think_s: float) -> None:
    """Measure a program, and add its row to the table."""
    with (
        tempfile.TemporaryDirectory() as name,
        running(program, Path(name)) as (port, start_s, process),
    ):
        program.fill(port, workers, 2 * each)
        fast = drive(program, (port, process.pid), workers, each, 0.0)
        slow = drive(program, (port, process.pid), workers, max(1, each // 4), think_s)
    row(
        f"{workers} workers, one process: {program.name}",
        f"{fast.per_s:.0f} answers/s, p95 {fast.answer_p95:.0f} ms; first page {start_s:.1f} s; "
        f"{fast.processor_ms:.1f} ms of processor an answer; {fast.refused + slow.refused} errors",
        f"with {think_s:g} s to think p50 {slow.answer_p50:.0f} ms, p95 {slow.answer_p95:.0f} ms",
    )


def made(kind: type[Ours | Potato | LabelStudio], folder: Path) -> Program:
    """Return a program, installed if it isn't ours."""
    return Ours() if issubclass(kind, Ours) else kind(installed(kind.package, folder))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, prog="python -m benchmarks.peers")
    parser.add_argument("--workers", type=int, default=50)
    parser.add_argument("--each", type=int, default=8, help="answers of a worker (8)")
    parser.add_argument("--think", type=float, default=5.0, help="mean seconds (5)")
    parser.add_argument("--only", default="", metavar="TEXT", help="programs whose name has this")
    parser.add_argument(
        "--folder", type=Path, default=Path("benchmark-data/peers"), help="environments"
    )
    given = parser.parse_args()
    missing = []
    for kind in (Ours, *PEERS):
        if given.only.lower() in kind.name.lower():
            try:
                program = made(kind, given.folder.resolve())
                measure(program, given.workers, given.each, given.think)
            except (OSError, subprocess.SubprocessError, AssertionError) as error:
                missing.append(f"{kind.name}: left out: {error}")
    print("", *missing, sep="\n")


if __name__ == "__main__":
    main()
