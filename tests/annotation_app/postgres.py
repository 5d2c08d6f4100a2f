"""A PostgreSQL cluster of the tests' own."""

from __future__ import annotations

import contextlib
import functools
import os
import pwd
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest


def programs() -> Path | None:
    """Where PostgreSQL's server programs are."""
    found = shutil.which("initdb")
    folders = [Path(found).parent] if found else []
    folders += sorted(Path("/usr/lib/postgresql").glob("*/bin"), reverse=True)
    return next((folder for folder in folders if (folder / "initdb").exists()), None)


@dataclass(frozen=True)
class Cluster:
    """A cluster, which can be stopped and started; it listens at a socket only.

    Parameters
    ----------
    url
        Where it is, without the database's name.
    """

    url: str
    _control: Callable[..., None]
    _options: str

    def start(self) -> None:
        self._control("-o", self._options, "start")

    def stop(self, how: str = "immediate") -> None:
        self._control("-m", how, "stop")


@contextmanager
def cluster(*, durable: bool = False) -> Iterator[str]:
    """The URL of a new cluster; see :func:`running_cluster`."""
    with running_cluster(durable=durable) as running:
        yield running.url


@contextmanager
def running_cluster(*, durable: bool = False) -> Iterator[Cluster]:
    """A new cluster.

    Parameters
    ----------
    durable
        Whether what is committed must survive a power cut, which takes time.
    """
    folder = programs()
    if folder is None:
        pytest.skip("PostgreSQL's server is not installed")
    user = None
    home = Path(tempfile.mkdtemp(prefix="ct-pg-"))
    if os.geteuid() == 0:
        # PostgreSQL refuses to run as root.
        user = next((name for name in ("postgres", "nobody") if _exists(name)), None)
        if user is None:
            pytest.skip("PostgreSQL can't run as root, and there is no other user")
        shutil.chown(home, user)
    data = home / "data"

    def run(*arguments: str) -> None:
        subprocess.run(arguments, check=True, user=user, cwd=home, capture_output=True, env={})

    try:
        run(
            str(folder / "initdb"), "-D", str(data), "-U", "tests", "-A", "trust",
            "--no-sync", "-E", "UTF8",
        )  # fmt: skip
        options = f"-c listen_addresses='' -c unix_socket_directories={home} -c max_connections=200"
        if not durable:
            options += " -c fsync=off -c full_page_writes=off -c autovacuum=off"
        control = str(folder / "pg_ctl"), "-D", str(data), "-w", "-l", str(home / "log")
        url = f"postgresql://tests@/{{name}}?host={home}"
        made = Cluster(url, functools.partial(run, *control), options)
        made.start()
        try:
            yield made
        finally:
            with contextlib.suppress(subprocess.CalledProcessError):  # it may be stopped already
                made.stop()
    finally:
        shutil.rmtree(home, ignore_errors=True)


def _exists(user: str) -> bool:
    try:
        pwd.getpwnam(user)
    except KeyError:
        return False
    return True
