"""What commands cost that run once: ``python -m benchmarks.cold_start``.

Processor time of a process of its own for each, imports included. Whatever is made once and then
kept (a model, WordNet's arrays, compiled modules) is made before. With ``--beside``, another
checkout takes turns with this one.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

from benchmarks.timing import aim, heading, show

COMMAND = "Pick up the leftmost pallet"
FOLLOWING = "ct follow --plan-only"
CT = ("-m", "corpus_tools")
CASES = {
    "ct --help": (*CT, "--help"),
    "import ct": ("-c", "import ct"),
    "ct parse": (*CT, "parse", COMMAND),
    FOLLOWING: (
        *CT, "follow", COMMAND, "--scenario", "aisles_pick_up_second_tires", "--plan-only",
    ),
}  # fmt: skip


def processor_time(arguments: tuple[str, ...], checkout: Path, compiled: str) -> float:
    """Seconds that a Python process takes, of the user's and the system's time together."""
    surroundings = {**os.environ, "PYTHONPATH": str(checkout), "PYTHONPYCACHEPREFIX": compiled}
    surroundings.pop("PYTHONDONTWRITEBYTECODE", None)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(
        [sys.executable, *arguments], cwd=checkout, env=surroundings, check=True,
        stdout=subprocess.DEVNULL,
    )  # fmt: skip
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.cold_start", description=__doc__)
    parser.add_argument("--beside", type=Path, metavar="PATH", help="another checkout")
    parser.add_argument("--runs", type=int, default=7, help="of each command (7)")
    given = parser.parse_args()
    checkouts = {"": Path(__file__).resolve().parents[1]}
    if given.beside is not None:
        checkouts[", beside"] = given.beside.resolve()
    heading("Cold start (processor time: median and least)")
    with tempfile.TemporaryDirectory() as compiled:
        for what, arguments in CASES.items():
            # Older checkouts have no front door.
            with_it = {
                n: c for n, c in checkouts.items() if what != "import ct" or (c / "ct").is_dir()
            }
            times: dict[str, list[float]] = {name: [] for name in with_it}
            for run in range(given.runs + 1):
                for name, checkout in with_it.items():
                    seconds = processor_time(arguments, checkout, compiled)
                    times[name] += [seconds] if run else []
            for name, own in times.items():
                show(what + name, median(own), "s", f"least {min(own):.3g}")
            if what == FOLLOWING:
                measured = "; ".join(f"{median(own):.2f} s{name}" for name, own in times.items())
                least = median(times[""])
                aim(
                    f"{what}, cold, processor time",
                    measured,
                    "1.5 s",
                    reached=least <= 1.5,
                    reason="spaCy and its model take .8 s of it",
                )


if __name__ == "__main__":
    main()
