"""What tests have other processes do; it imports little, so that these start soon."""

from __future__ import annotations

import os
import signal
from pathlib import Path


def square(x):
    if x == 13:
        raise ValueError("unlucky")
    return x * x


def die_once(x, *, folder):
    """Ends its process the first time that it is called for an odd number."""
    mark = Path(folder) / str(x)
    if x % 2 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return x


def die(x):
    if x == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return x
