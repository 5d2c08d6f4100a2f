"""Python in processes of its own: what is imported, printed and returned there."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from multiprocessing import get_context
from multiprocessing.context import ForkServerProcess
from pathlib import Path


def python(
    *arguments: object, cwd: Path | None = None, **variables: str
) -> subprocess.CompletedProcess[str]:
    """Run Python with arguments, and with some of the environment's variables changed."""
    return subprocess.run(
        [sys.executable, *map(str, arguments)],
        cwd=cwd,
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        encoding="utf-8",
        timeout=300,
        check=False,
    )


def ct(
    *arguments: object, cwd: Path | None = None, **variables: str
) -> subprocess.CompletedProcess[str]:
    """Run ``ct``."""
    return python("-m", "corpus_tools", *arguments, cwd=cwd, **variables)


def forked(
    function: Callable[..., object], *arguments: object, preload: Sequence[str] = ()
) -> ForkServerProcess:
    """Call a function in a process of its own, which may be killed.

    Processes are forked from one that has read the modules to preload, and those of the function.
    """
    context = get_context("forkserver")
    context.set_forkserver_preload([function.__module__, *preload])
    process = context.Process(target=_call, args=(function, arguments, dict(os.environ)))
    process.start()
    return process


def _call(
    function: Callable[..., object], arguments: Sequence[object], environment: Mapping[str, str]
) -> None:
    os.environ.update(environment)  # that of the first process is older
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    function(*arguments)
