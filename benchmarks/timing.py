"""Times, and the rows of the README's table."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")
MEASURED = "BENCHMARKS_MEASURED"
"""An environment variable: the file that :func:`row` writes to."""


def best(
    action: Callable[[], T], repeats: int = 3, clock: Callable[[], float] = time.perf_counter
) -> tuple[float, T]:
    """Return the least of a few times in seconds, which load disturbs least, and the result."""
    return best_of({"": action}, repeats, clock)[""]


def best_of(
    actions: Mapping[str, Callable[[], T]],
    repeats: int = 3,
    clock: Callable[[], float] = time.perf_counter,
) -> dict[str, tuple[float, T]]:
    """Return the least times of actions that take turns, so that load disturbs all alike."""
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
    """Return the last line that another Python process prints, which is JSON."""
    command = [sys.executable, *arguments]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return json.loads(done.stdout.splitlines()[-1])


def growth(sizes: Sequence[float], values: Sequence[float]) -> float:
    """Return the exponent of the power of the sizes that is nearest to the values."""
    if len(sizes) < 2:
        return float("nan")
    return float(np.polyfit(np.log(sizes), np.log(values), 1)[0])


def show(what: str, value: float, unit: str, note: str = "") -> None:
    number = f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.4g}"
    print(f"  {what:<52}{number:>12} {unit}{f'  ({note})' if note else ''}", flush=True)


def row(what: str, measured: str, against: str = "") -> None:
    """Print a figure, and keep it for the table.

    `against` is our time through a peer's, the exponent of growth, or another comparison.
    """
    print(f"  {what}: {measured}{f' ({against})' if against else ''}", flush=True)
    if MEASURED in os.environ:
        with Path(os.environ[MEASURED]).open("a", encoding="utf-8") as file:
            file.write(json.dumps([what, measured, against]) + "\n")


def most_mib() -> float:
    """Return the most memory so far; getrusage includes that of the parent."""
    status = Path("/proc/self/status").read_text()
    return int(re.findall(r"VmHWM:\s+(\d+) kB", status)[0]) / 1024
