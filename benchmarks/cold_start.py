"""Commands that run once: ``python -m benchmarks.cold_start``.

Processor time of a process of its own for each, imports included. A model, WordNet's arrays and
compiled modules, which are made once and kept, are made before.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from statistics import median

from benchmarks.timing import row

RUNS = 7
COMMAND = "Pick up the leftmost pallet"
CT = ("-m", "corpus_tools")
CASES = {
    "ct --help": (*CT, "--help"),
    "import ct": ("-c", "import ct"),
    "ct parse": (*CT, "parse", COMMAND),
    "ct follow --plan-only": (
        *CT, "follow", COMMAND, "--scenario", "aisles_pick_up_second_tires", "--plan-only",
    ),
}  # fmt: skip


def processor_time(arguments: tuple[str, ...], compiled: str) -> float:
    """Return the seconds that a Python process takes, of the user's and the system's time."""
    environment = {**os.environ, "PYTHONPYCACHEPREFIX": compiled}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, *arguments]
    subprocess.run(command, env=environment, check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    with tempfile.TemporaryDirectory() as compiled:
        for what, arguments in CASES.items():
            _, *times = (processor_time(arguments, compiled) for _ in range(RUNS + 1))
            row(f"{what}, cold", f"{median(times):.2f} s of processor, least {min(times):.2f} s")


if __name__ == "__main__":
    main()
