"""What the app's own ways gain beside simpler ones: ``python -m benchmarks.app_rooms``.

Each is put in place of the other in servers of their own, in turn, and takes the submissions of
``benchmarks.app_submissions``. Speeds vary with what else the machine does, ratios by less.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import sys
import tempfile
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from statistics import median
from typing import NamedTuple

from benchmarks.app_servers import new_databases, servers
from benchmarks.app_submissions import Figures, add_study, run


def wait_with_the_loop_of_waitress() -> None:
    """Ask each connection, and pass all to the kernel, whenever one has something."""
    from waitress import wasyncore  # noqa: PLC0415

    from annotation_app.serving.connections import Connections  # noqa: PLC0415

    def wait(self: Connections, timeout_s: float) -> None:
        wasyncore.poll2(timeout_s, self)

    Connections.wait = wait  # type: ignore[method-assign]


def let_sqlite_wait() -> None:
    """Writers try again after growing pauses, up to 20 s, as SQLite does by itself."""
    from annotation_app.store import database  # noqa: PLC0415

    database._turn = nullcontext  # type: ignore[assignment]


def try_each_connection() -> None:
    """Ask PostgreSQL for a sign of life before each request, as ``pool_pre_ping`` does."""
    from annotation_app.store import database  # noqa: PLC0415

    database.IDLE_S = -1


class Room(NamedTuple):
    """One of our own ways, and where it would be felt."""

    simpler: Callable[[], None]
    database: str
    processes: int
    workers: int
    at_once: int


ROOMS = {
    "loop": Room(wait_with_the_loop_of_waitress, "postgresql", 2, 600, 8),
    "loop, many connections": Room(wait_with_the_loop_of_waitress, "postgresql", 2, 1800, 8),
    "turnstile": Room(let_sqlite_wait, "sqlite", 8, 600, 64),
    "idle": Room(try_each_connection, "postgresql", 2, 600, 8),
}
OURS = "ours"


def measure(room: Room, program: list[str], folder: Path, database: str) -> Figures:
    """Submissions to new servers."""
    from annotation_app.core.config import open_instance  # noqa: PLC0415
    from benchmarks.app import cookies  # noqa: PLC0415

    with tempfile.TemporaryDirectory(dir=folder) as instance:
        config = open_instance(Path(instance) / "instance", database)
        signed = cookies(
            config, add_study(config, folder / "videos", room.workers, room.workers, 1)
        )
        with servers(config, room.processes, threads=8, program=program) as running:
            return asyncio.run(run([server.port for server in running], signed, room.at_once, 1))


def compare(name: str, rounds: int) -> None:
    """Measure a room and what is simpler in turn."""
    from tests.annotation_app.rendered import render  # noqa: PLC0415

    room = ROOMS[name]
    print(
        f"{name}: {room.database}, {room.processes} processes, {room.workers} connections, "
        f"{room.at_once} at once, {rounds} rounds, load {os.getloadavg()[0]:.1f}",
        flush=True,
    )
    found: dict[str, list[Figures]] = {"ours": [], "simpler": []}
    here = ["-m", "benchmarks.app_rooms"]
    with tempfile.TemporaryDirectory() as folder, new_databases(room.database) as new:
        render(Path(folder) / "videos", ("one", "two"))
        for _ in range(rounds):
            for which, serve in (("ours", OURS), ("simpler", name)):
                one = measure(room, [*here, "--serve", serve], Path(folder), new())
                found[which].append(one)
    for which, figures in found.items():
        rates = [one.per_s for one in figures]
        print(
            f"  {which:8} {median(rates):4.0f} submissions/s ({min(rates):.0f} to "
            f"{max(rates):.0f}), p50 {median(one.p50 for one in figures):.0f} ms, "
            f"p95 {median(one.p95 for one in figures):.0f} ms, "
            f"longest {max(one.longest for one in figures):.0f} ms, "
            f"servers {median(one.processor['servers'] for one in figures):.1f} ms each",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, prog="python -m benchmarks.app_rooms")
    parser.add_argument("names", nargs="*", default=[], metavar="ROOM", help=", ".join(ROOMS))
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--serve", help=argparse.SUPPRESS)
    if "--serve" in sys.argv[1:2]:
        given, rest = sys.argv[2], sys.argv[3:]
        if given != OURS:
            ROOMS[given].simpler()
        from corpus_tools.cli.console import main as ct  # noqa: PLC0415

        ct(rest)
    chosen = parser.parse_args()
    for name in chosen.names or ROOMS:
        compare(name, chosen.rounds)


if __name__ == "__main__":
    main()
