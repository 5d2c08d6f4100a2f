"""Python in processes of its own: what is imported, printed and returned there."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping
from multiprocessing import get_context
from multiprocessing.context import ForkServerProcess
from pathlib import Path

from corpus_tools.cli import console


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


def forked_ct(*arguments: object, preload: tuple[str, ...]) -> ForkServerProcess:
    """Start ``ct`` in a process of its own that needn't read modules again, to be killed."""
    context = get_context("forkserver")
    context.set_forkserver_preload(list(preload))
    process = context.Process(target=_run, args=([*map(str, arguments)], dict(os.environ)))
    process.start()
    return process


def _run(arguments: list[str], environment: Mapping[str, str]) -> None:
    os.environ.update(environment)  # that of the server is older
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    os.dup2(null, 2)
    sys.exit(console.run(arguments))
