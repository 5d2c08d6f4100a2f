"""Taking times and printing them."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

T = TypeVar("T")


def best(
    action: Callable[[], T], repeats: int = 3, clock: Callable[[], float] = time.perf_counter
) -> tuple[float, T]:
    """The least of a few times in seconds, which load disturbs least, and the result."""
    return best_of({"": action}, repeats, clock)[""]


def best_of(
    actions: Mapping[str, Callable[[], T]],
    repeats: int = 3,
    clock: Callable[[], float] = time.perf_counter,
) -> dict[str, tuple[float, T]]:
    """The least times of actions that take turns, so that load disturbs all of them alike."""
    results: dict[str, tuple[float, T]] = {}
    for _ in range(repeats):
        for name, action in actions.items():
            start = clock()
            value = action()
            seconds = clock() - start
            if name not in results or seconds < results[name][0]:
                results[name] = (seconds, value)
    return results


def in_own_process(*arguments: str) -> Any:
    """What another Python process prints in its last line, as JSON."""
    command = [sys.executable, *arguments]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return json.loads(done.stdout.splitlines()[-1])


def heading(text: str) -> None:
    print(f"\n{text}", flush=True)


def show(what: str, value: float, unit: str, note: str = "") -> None:
    number = f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.4g}"
    print(f"  {what:<52}{number:>12} {unit}{f'  ({note})' if note else ''}", flush=True)


@dataclass(frozen=True, slots=True)
class Comparison:
    """Our time through a peer's, for the same work in the same run.

    Parameters
    ----------
    what
        The work.
    peer
        Who does it too.
    ratio
        Ours through theirs; less than 1 is faster.
    limit
        What no program gets below on this machine.
    """

    what: str
    peer: str
    ratio: float
    limit: str


MEASURED = "BENCHMARKS_MEASURED"
"""Names the file that :func:`aim` writes to, in the surroundings."""


def aim(what: str, measured: str, reach: str, *, reached: bool, reason: str = "") -> None:
    """Print a figure with its aim, and keep it for the table of ``benchmarks.everything``.

    Parameters
    ----------
    what
        What was measured.
    measured
        The figure.
    reach
        What it should be.
    reached
        Whether it is.
    reason
        Why it may not be, as far as it is known.
    """
    outcome = "yes" if reached else f"no{': ' * bool(reason)}{reason}"
    print(f"  {what}: {measured} (aim: {reach}; reached: {outcome})", flush=True)
    if MEASURED in os.environ:
        with Path(os.environ[MEASURED]).open("a", encoding="utf-8") as file:
            file.write(json.dumps([what, measured, reach, outcome]) + "\n")


COMPARISONS: list[Comparison] = []
"""All of this run."""


def compare(what: str, peer: str, ratio: float, limit: str) -> None:
    """Print our time through a peer's, and keep it for the table."""
    show(f"{what}: ours / {peer}", ratio, "")
    COMPARISONS.append(Comparison(what, peer, ratio, limit))


def table() -> None:
    """Print all comparisons of this run in Markdown."""
    heading("| What | Beside | Our time / theirs | Limit |\n|---|---|---:|---|")
    for one in COMPARISONS:
        print(f"| {one.what} | {one.peer} | {one.ratio:.2f} | {one.limit} |")


def most_mib() -> float:
    """The most memory so far; what getrusage tells includes that of the parent."""
    status = Path("/proc/self/status").read_text()
    return int(re.findall(r"VmHWM:\s+(\d+) kB", status)[0]) / 1024
