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
from pathlib import Path

from benchmarks.timing import MEASURED

PAGE = Path(__file__).with_name("README.md")
MARKS = ("<!-- measured in one run -->", "<!-- until here -->")
"""``--write`` replaces the lines between them."""
COMMANDS = """\
reading {slu_core}
learning {corpus}
parsing {corpus}
growth {corpus}
inference
logs
many_episodes
rendering
jobs
cold_start
app_dashboard --databases sqlite --answers 1000 100000
app_drags
app_try
app --databases postgresql --processes 2 --workers 200 --no-kill --think 0
app --databases postgresql --processes 4 --workers 1000 --no-kill --seconds 90
peers --folder {folder}
"""
"""The benchmarks in order, each with its arguments."""


def measure(command: str) -> tuple[list[list[str]], int]:
    """Run a benchmark; return its rows of the table, and its exit status."""
    module, *arguments = shlex.split(command)
    # Paths of one machine say nothing to others.
    shown = " ".join([module, *(Path(word).name if "/" in word else word for word in arguments)])
    with tempfile.TemporaryDirectory() as name:
        file = Path(name) / "measured"
        file.touch()
        status = subprocess.run(
            [sys.executable, "-m", f"benchmarks.{module}", *arguments],
            env={**os.environ, MEASURED: str(file)},
            check=False,
        ).returncode
        lines = file.read_text(encoding="utf-8").splitlines()
    return [[*json.loads(line), f"`{shown}`"] for line in lines], status


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--corpus", default="warehouse", help="a corpus (warehouse)")
    parser.add_argument("--slu-core", metavar="PATH", help="the data of slu_core")
    parser.add_argument("--folder", default="benchmark-data", help="for peers")
    parser.add_argument("--only", default="", metavar="TEXT", help="commands that contain this")
    parser.add_argument("--list", action="store_true", help="show the commands, run nothing")
    parser.add_argument("--write", action="store_true", help="put the table into the README")
    given = parser.parse_args()
    quoted = {name: shlex.quote(str(value)) for name, value in vars(given).items()}
    chosen = [line.format(**quoted) for line in COMMANDS.splitlines()[not given.slu_core :]]
    chosen = [command for command in chosen if given.only in command]
    if given.list:
        print(*chosen, sep="\n")
        return
    start = time.perf_counter()
    rows: list[list[str]] = []
    failed: list[str] = []
    for number, command in enumerate(chosen, start=1):
        print(f"\n=== {number} of {len(chosen)}: {command}", flush=True)
        measured, status = measure(command)
        rows += measured
        failed += [command] if status else []
    block = (
        f"{time.strftime('%Y-%m-%d')}, {(time.perf_counter() - start) / 60:.0f} minutes, "
        f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} at the end, "
        f"Python {platform.python_version()}.\n\n"
        "| What | Measured | Against | Command |\n| --- | --- | --- | --- |\n"
    ) + "".join(f"| {' | '.join(row)} |\n" for row in rows)
    print(f"\n{block}", *(f"failed: {command}" for command in failed), sep="\n")
    if given.write:
        begin, end = MARKS
        text = PAGE.read_text(encoding="utf-8")
        page = re.sub(f"(?s){begin}.*{end}", lambda _: f"{begin}\n{block}\n{end}", text)
        PAGE.write_text(page, encoding="utf-8")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
