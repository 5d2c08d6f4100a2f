"""All measurements of the README, one after the other: ``python -m benchmarks``.

It takes about an hour, most of it for peers and videos. ``--only`` runs some.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.timing import MEASURED

PAGE = Path(__file__).with_name("README.md")
MARKS = ("<!-- measured in one run -->", "<!-- until here -->")
"""``--write`` replaces the lines between them."""


def commands(corpus: str, slu_core: Path | None, folder: Path) -> Iterator[str]:
    """Yield the benchmarks in order, each with its arguments."""
    if slu_core:
        yield shlex.join(["reading", str(slu_core)])
    yield f"extraction {corpus}"
    yield f"training {corpus}"
    yield f"parsing {corpus}"
    yield f"growth {corpus}"
    yield "inference"
    yield "logs"
    yield "many_episodes"
    yield "rendering"
    yield "jobs"
    yield "cold_start"
    yield "app_leases"
    yield "app_dashboard --databases sqlite --answers 1000 100000"
    yield "app_submissions"
    yield "app_drags"
    yield "app --databases postgresql --processes 4 --workers 1000 --no-kill --seconds 90"
    yield shlex.join(["peers", "--folder", str(folder)])


def measure(chosen: Sequence[str]) -> tuple[list[list[str]], list[str]]:
    """Run benchmarks; return the rows of the table, and the commands that failed."""
    rows: list[list[str]] = []
    failed: list[str] = []
    with tempfile.TemporaryDirectory() as name:
        file = Path(name) / "measured"
        for number, command in enumerate(chosen, start=1):
            print(f"\n=== {number} of {len(chosen)}: {command}", flush=True)
            file.write_bytes(b"")
            module, *arguments = shlex.split(command)
            status = subprocess.run(
                [sys.executable, "-m", f"benchmarks.{module}", *arguments],
                env={**os.environ, MEASURED: str(file)},
                check=False,
            ).returncode
            # Paths of one machine say nothing to others.
            shown = " ".join(Path(word).name if "/" in word else word for word in arguments)
            lines = file.read_text(encoding="utf-8").splitlines()
            rows += [[*json.loads(line), f"`{f'{module} {shown}'.strip()}`"] for line in lines]
            failed += [command] if status else []
    return rows, failed


def write(page: Path, block: str) -> None:
    """Put a block between the two marks of a page."""
    begin, end = MARKS
    text, count = re.subn(
        f"(?s){begin}.*{end}", lambda _: f"{begin}\n{block}\n{end}", page.read_text("utf-8")
    )
    if count != 1:
        raise SystemExit(f"{page} needs the lines {begin} and {end} once")
    page.write_text(text, encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--corpus", default="warehouse", help="a corpus (warehouse)")
    parser.add_argument("--slu-core", type=Path, metavar="PATH", help="the data of slu_core")
    parser.add_argument("--folder", type=Path, default=Path("benchmark-data"), help="for peers")
    parser.add_argument("--only", default="", metavar="TEXT", help="commands that contain this")
    parser.add_argument("--list", action="store_true", help="show the commands, run nothing")
    parser.add_argument("--write", action="store_true", help="put the table into the README")
    given = parser.parse_args()
    every = commands(given.corpus, given.slu_core, given.folder)
    chosen = [command for command in every if given.only in command]
    if given.list:
        print(*chosen, sep="\n")
        return
    start = time.perf_counter()
    rows, failed = measure(chosen)
    block = (
        f"{time.strftime('%Y-%m-%d')}, {(time.perf_counter() - start) / 60:.0f} minutes, "
        f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} at the end, "
        f"Python {platform.python_version()}.\n\n"
        "| What | Measured | Against | Command |\n| --- | --- | --- | --- |\n"
    ) + "".join(f"| {' | '.join(row)} |\n" for row in rows)
    print(f"\n{block}", *(f"failed: {command}" for command in failed), sep="\n")
    if given.write:
        write(PAGE, block)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
